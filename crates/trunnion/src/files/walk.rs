//! Checks a TOML tree against a JSON schema: the part of JSON schema that derived layouts use.

use super::path::{blame, join};
use serde_json::{Map, Value};
use std::borrow::Cow;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Violation of the schema at a byte offset; none for the file as a whole.
#[derive(Debug)]
pub(super) struct SchemaFinding {
    /// Dotted path of the table or value that cannot be read because of it.
    pub(super) path: String,
    pub(super) offset: Option<usize>,
    pub(super) message: String,
    pub(super) help: String,
}

/// Path of a finding that does not keep its table from being read.
const ELSEWHERE: &str = "?";

/// Returns all violations of the schema by `root`.
pub(super) fn check(schema: &Value, root: &DeTable<'_>) -> Vec<SchemaFinding> {
    let mut walk = Walk { top: schema, found: Vec::new() };
    walk.table(schema, root, "", None);
    walk.found
}

struct Walk<'s> {
    top: &'s Value,
    found: Vec<SchemaFinding>,
}

impl Walk<'_> {
    fn add(&mut self, path: &str, offset: Option<usize>, message: String, help: String) {
        self.found.push(SchemaFinding { path: path.to_owned(), offset, message, help });
    }

    fn table(&mut self, schema: &Value, table: &DeTable<'_>, path: &str, offset: Option<usize>) {
        let none = Map::new();
        let properties = schema.get("properties").and_then(Value::as_object).unwrap_or(&none);
        let others = schema.get("additionalProperties");
        let mut misspelt = Vec::new();
        for (key, value) in table {
            let inner = join(path, key.get_ref());
            let others = others.filter(|others| others.is_object());
            match properties.get(key.get_ref().as_ref()).or(others) {
                Some(schema) => self.value(schema, value, &inner, blame(key, value)),
                None => misspelt.extend(self.unknown(key, properties, path)),
            }
        }
        let required = schema.get("required").and_then(Value::as_array);
        // A key that is misspelt is not missing as well.
        for key in required.into_iter().flatten().filter_map(Value::as_str) {
            if !table.contains_key(key) && !misspelt.contains(&key) {
                self.missing(properties.get(key), key, path, offset);
            }
        }
    }

    fn missing(&mut self, schema: Option<&Value>, key: &str, path: &str, offset: Option<usize>) {
        let about = schema.map(description).unwrap_or_default();
        let is_table = schema.is_some_and(|schema| type_of(schema).contains(&"object"));
        let full = join(path, key);
        let (what, add) = if is_table {
            (format!("table [{full}]"), format!("[{full}]"))
        } else {
            (format!("key `{key}`{}", within(path)), format!("`{key} = {}`", example(schema)))
        };
        // At the top, the missing table alone is faulty: other sections are still read.
        let whose = if path.is_empty() { full } else { path.to_owned() };
        self.add(&whose, offset, format!("missing {what}"), sentence(&format!("add {add}"), about));
    }

    /// Reports an unknown key; returns the known one it was probably meant to be.
    fn unknown<'k>(
        &mut self,
        key: &Spanned<Cow<'_, str>>,
        known: &'k Map<String, Value>,
        path: &str,
    ) -> Option<&'k str> {
        let name = key.get_ref().as_ref();
        let names: Vec<&str> = known.keys().map(String::as_str).collect();
        let nearest = nearest(name, &names).or_else(|| last_words(name, &names));
        // From the likeliest mistake to the least: a typing error, a key of another table, a table
        // written as a key.
        let help = if let Some(nearest) = nearest {
            format!("did you mean `{nearest}`?")
        } else if let Some((table, longer)) = self.of_this_table(name, path) {
            format!("did you mean `{longer}` in [{table}]?")
        } else if let Some(table) = self.elsewhere(name, path) {
            format!("`{name}` belongs in [{table}]")
        } else if let Some(table) = self.table_at_the_top(name) {
            format!("it is a table of its own: {table}")
        } else {
            format!("known here: {}", names.join(", "))
        };
        let message = format!("unknown key `{name}`{}", within(path));
        // Without the key that was meant, the table is not to be judged.
        let whose = if nearest.is_some() { path } else { ELSEWHERE };
        self.add(whose, Some(key.span().start), message, help);
        nearest
    }

    /// Finds a key of another table that names this one: `cell` in [stock] is `stock_cell` in [verify].
    fn of_this_table(&self, name: &str, path: &str) -> Option<(String, String)> {
        let longer = format!("{}_{name}", path.split('.').next()?);
        self.elsewhere(&longer, path).map(|table| (table, longer))
    }

    /// Returns a table at the top of the layout, or a list of them, as it is written.
    fn table_at_the_top(&self, name: &str) -> Option<String> {
        let schema = self.top.get("properties")?.get(name)?;
        if is_list_of_tables(schema) {
            return Some(format!("[[{name}]]"));
        }
        type_of(schema).contains(&"object").then(|| format!("[{name}]"))
    }

    /// Finds a table at the top of the layout that knows a key.
    fn elsewhere(&self, name: &str, path: &str) -> Option<String> {
        let tables = self.top.get("properties")?.as_object()?;
        let knows = |table: &Value| table.get("properties").is_some_and(|p| p.get(name).is_some());
        tables
            .iter()
            .find(|(table, schema)| *table != path && knows(schema))
            .map(|(t, _)| t.clone())
    }

    fn value(&mut self, schema: &Value, value: &Spanned<DeValue<'_>>, path: &str, at: usize) {
        // Words first: schemars lists them as branches of a choice, in which each would fail alone.
        let words = constants(schema);
        if !words.is_empty() && matches!(value.get_ref(), DeValue::String(_)) {
            return self.word(&words, value.get_ref(), path, at);
        }
        let branches =
            schema.get("anyOf").or_else(|| schema.get("oneOf")).and_then(Value::as_array);
        if let Some(branches) = branches {
            let fits = |branch: &&Value| accepts(branch, value.get_ref());
            // The type selects the branch, so that its own message explains the value.
            return match branches.iter().find(fits) {
                Some(branch) => self.value(branch, value, path, at),
                None => self.wrong_type(schema, value.get_ref(), path, at),
            };
        }
        if !accepts(schema, value.get_ref()) {
            return self.wrong_type(schema, value.get_ref(), path, at);
        }
        match value.get_ref() {
            DeValue::Table(table) => self.table(schema, table, path, Some(at)),
            DeValue::Array(items) => self.array(schema, items, path, at),
            DeValue::Integer(_) | DeValue::Float(_) => {
                self.number(schema, value.get_ref(), path, at);
            }
            DeValue::String(text) => {
                let least = schema.get("minLength").and_then(Value::as_u64).unwrap_or(0);
                if text.trim().is_empty() && least > 0 {
                    let message = format!("`{path}` is empty");
                    self.add(
                        path,
                        Some(at),
                        message,
                        sentence("write a text", description(schema)),
                    );
                }
            }
            DeValue::Boolean(_) | DeValue::Datetime(_) => {}
        }
    }

    fn word(&mut self, words: &[&str], value: &DeValue<'_>, path: &str, at: usize) {
        let DeValue::String(found) = value else { return };
        if words.contains(&found.as_ref()) {
            return;
        }
        let list = words.iter().map(|word| format!("{word:?}")).collect::<Vec<_>>().join(", ");
        let help = match nearest(found, words) {
            Some(nearest) => format!("did you mean {nearest:?}? It can be {list}"),
            None => format!("it can be {list}"),
        };
        self.add(path, Some(at), format!("`{path}` cannot be {found:?}"), help);
    }

    fn array(&mut self, schema: &Value, items: &[Spanned<DeValue<'_>>], path: &str, at: usize) {
        let size = |key: &str| {
            schema.get(key).and_then(Value::as_u64).and_then(|size| usize::try_from(size).ok())
        };
        let [least, most] = [size("minItems"), size("maxItems")];
        let too_few = least.is_some_and(|least| items.len() < least);
        if too_few || most.is_some_and(|most| items.len() > most) {
            let wanted = match (least, most) {
                (Some(least), Some(most)) if least == most => format!("{least}"),
                (Some(least), _) if too_few => format!("at least {least}"),
                (_, most) => format!("at most {}", most.unwrap_or_default()),
            };
            let message = format!("`{path}` needs {wanted} entries, but has {}", items.len());
            self.add(path, Some(at), message, sentence("", description(schema)));
        }
        if let Some(schema) = schema.get("items") {
            for (index, item) in items.iter().enumerate() {
                self.value(schema, item, &join(path, &index.to_string()), item.span().start);
            }
        }
    }

    fn number(&mut self, schema: &Value, value: &DeValue<'_>, path: &str, at: usize) {
        let (text, number) = match value {
            DeValue::Integer(integer) => {
                // Kept as text: an integer beyond 64 bits is a fault here, not a rounding.
                let whole = i64::from_str_radix(integer.as_str(), integer.radix()).ok();
                (integer.to_string(), whole.map(|whole| whole as f64))
            }
            DeValue::Float(float) => (float.to_string(), float.as_str().parse().ok()),
            _ => return,
        };
        let about = description(schema);
        let Some(number) = number.filter(|number: &f64| number.is_finite()) else {
            // NaN and infinity are valid TOML.
            let message = format!("`{path}` = {text} is not a finite number");
            self.add(path, Some(at), message, sentence("write a finite number", about));
            return;
        };
        let bound = |key: &str| schema.get(key).and_then(Value::as_f64);
        // Integer types have their range in the format, not as a maximum.
        let format_maximum = match schema.get("format").and_then(Value::as_str) {
            Some("uint8") => Some(f64::from(u8::MAX)),
            Some("uint32") => Some(f64::from(u32::MAX)),
            _ => None,
        };
        let wanted = if let Some(low) = bound("exclusiveMinimum").filter(|low| number <= *low) {
            format!("above {low}")
        } else if let Some(low) = bound("minimum").filter(|low| number < *low) {
            format!("at least {low}")
        } else if let Some(high) = bound("exclusiveMaximum").filter(|high| number >= *high) {
            format!("below {high}")
        } else if let Some(high) = bound("maximum").or(format_maximum).filter(|high| number > *high)
        {
            format!("at most {high}")
        } else {
            return;
        };
        self.add(
            path,
            Some(at),
            format!("`{path}` = {text} must be {wanted}"),
            sentence("", about),
        );
    }

    fn wrong_type(&mut self, schema: &Value, value: &DeValue<'_>, path: &str, at: usize) {
        let mut types = type_of(schema);
        types.dedup();
        let names: Vec<&str> = types.iter().map(|name| toml_name(name)).collect();
        let wanted = names.join(" or ");
        let help = match value {
            // A number in quotes is the most frequent mistake of beginners in TOML.
            DeValue::String(text)
                if names.iter().any(|name| name.contains("number"))
                    && text.trim().parse::<f64>().is_ok() =>
            {
                format!("write it without quotes: {}", text.trim())
            }
            // [[name]] where [name] is meant.
            DeValue::Array(items)
                if types.contains(&"object")
                    && items.iter().all(|item| matches!(item.get_ref(), DeValue::Table(_))) =>
            {
                format!("write [{path}] with single brackets, once")
            }
            _ if is_list_of_tables(schema) => {
                format!("write [[{path}]] with double brackets, once for each")
            }
            _ => sentence("", description(schema)),
        };
        let message = format!("`{path}` must be {wanted}, not {}", value_name(value));
        self.add(path, Some(at), message, help);
    }
}

fn within(path: &str) -> String {
    match path.rsplit_once('.') {
        _ if path.is_empty() => " at the top".to_owned(),
        Some((list, index)) if index.parse::<usize>().is_ok() => format!(" in [[{list}]]"),
        _ => format!(" in [{path}]"),
    }
}

/// Joins a remedy and the description of the key.
fn sentence(first: &str, about: &str) -> String {
    // Descriptions are broken into lines where the source is.
    let about = about.replace('\n', " ");
    match (first.is_empty(), about.is_empty()) {
        (true, _) => about,
        (false, true) => first.to_owned(),
        (false, false) => format!("{first}: {about}"),
    }
}

fn description(schema: &Value) -> &str {
    let text = schema.get("description").and_then(Value::as_str).unwrap_or_default();
    // The first paragraph suffices for a message.
    text.split("\n\n").next().unwrap_or_default()
}

/// Returns an example of a missing value.
fn example(schema: Option<&Value>) -> String {
    let Some(schema) = schema else { return "...".into() };
    if let Some(word) = schema.get("const").or_else(|| schema.get("default")) {
        return word.to_string();
    }
    if let Some(word) = constants(schema).first() {
        return format!("{word:?}");
    }
    match type_of(schema).first() {
        Some(&"string") => "\"...\"".into(),
        Some(&"array") => "[...]".into(),
        Some(&"boolean") => "false".into(),
        _ => "...".into(),
    }
}

/// Returns the words that a string may be; empty if it is free.
fn constants(schema: &Value) -> Vec<&str> {
    if let Some(word) = schema.get("const").and_then(Value::as_str) {
        return vec![word];
    }
    let listed = schema.get("enum").and_then(Value::as_array);
    let listed = listed.into_iter().flatten().filter_map(Value::as_str);
    let branches = schema.get("oneOf").or_else(|| schema.get("anyOf")).and_then(Value::as_array);
    let branches = branches.into_iter().flatten().flat_map(constants);
    listed.chain(branches).collect()
}

/// Returns the JSON types that a schema accepts.
fn type_of(schema: &Value) -> Vec<&str> {
    match schema.get("type") {
        Some(Value::String(name)) => vec![name],
        Some(Value::Array(names)) => names.iter().filter_map(Value::as_str).collect(),
        _ => {
            let branches = schema.get("oneOf").or_else(|| schema.get("anyOf"));
            let branches = branches.and_then(Value::as_array);
            let mut types: Vec<&str> = Vec::new();
            for name in branches.into_iter().flatten().flat_map(type_of) {
                if !types.contains(&name) {
                    types.push(name);
                }
            }
            types
        }
    }
}

fn accepts(schema: &Value, value: &DeValue<'_>) -> bool {
    let types = type_of(schema);
    types.is_empty()
        || types.iter().any(|name| match value {
            DeValue::String(_) => *name == "string",
            // `vel = 100` needs no decimal point.
            DeValue::Integer(_) => matches!(*name, "integer" | "number"),
            DeValue::Float(_) => *name == "number",
            DeValue::Boolean(_) => *name == "boolean",
            DeValue::Datetime(_) => false,
            DeValue::Array(_) => *name == "array",
            DeValue::Table(_) => *name == "object",
        })
}

fn toml_name(json_type: &str) -> &str {
    match json_type {
        "object" => "a table",
        "array" => "a list",
        "string" => "a text in quotes",
        "number" => "a number",
        "integer" => "a whole number",
        "boolean" => "true or false",
        other => other,
    }
}

fn value_name(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) => "a number",
        DeValue::Float(_) => "a decimal number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

fn is_list_of_tables(schema: &Value) -> bool {
    schema.get("items").is_some_and(|items| type_of(items).contains(&"object"))
}

/// Finds the only known name that ends with these words: `cell` is `stock_cell`.
fn last_words<'n>(name: &str, known: &[&'n str]) -> Option<&'n str> {
    let ending = format!("_{name}");
    let mut longer = known.iter().filter(|known| known.ends_with(&ending));
    longer.next().filter(|_| longer.next().is_none()).copied()
}

/// Finds the known name that a user may have meant: at an edit distance of at most a third of its
/// letters, where a swap of neighbours counts once.
pub(super) fn nearest<'n>(name: &str, known: &[&'n str]) -> Option<&'n str> {
    known
        .iter()
        .map(|known| (strsim::osa_distance(&name.to_lowercase(), known), *known))
        .filter(|(distance, known)| *distance <= (known.chars().count() / 3).max(1))
        .min()
        .map(|(_, known)| known)
}
