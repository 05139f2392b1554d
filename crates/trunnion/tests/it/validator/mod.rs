//! A JSON schema validator for the part of JSON schema that derived layouts use, independent of the
//! library's own.

use serde_json::{Map, Value};

/// What a schema forbids in a value: path, rule and value of each breach.
pub(crate) fn breaches(schema: &Value, value: &Value, path: &str) -> Vec<String> {
    let mut found: Vec<String> = broken_rules(schema, value, path)
        .iter()
        .map(|rule| format!("{path}: {rule}: {value}"))
        .collect();
    for (index, item) in value.as_array().into_iter().flatten().enumerate() {
        found.extend(breaches(&schema["items"], item, &format!("{path}.{index}")));
    }
    if let Some(table) = value.as_object() {
        found.extend(in_table(schema, table, path));
    }
    found
}

fn broken_rules(schema: &Value, value: &Value, path: &str) -> Vec<&'static str> {
    let some_branch = |key: &str| {
        let mut branches = schema[key].as_array().into_iter().flatten();
        schema.get(key).is_none() || branches.any(|one| breaches(one, value, path).is_empty())
    };
    let number = value.as_f64();
    let bound = |key: &str, breaks: fn(f64, f64) -> bool| {
        number.zip(schema[key].as_f64()).is_none_or(|(number, bound)| !breaks(number, bound))
    };
    let count = value.as_array().map(|items| items.len() as u64);
    let size = |key: &str, breaks: fn(u64, u64) -> bool| {
        count.zip(schema[key].as_u64()).is_none_or(|(count, size)| !breaks(count, size))
    };
    let long = |text: &str| text.len() as u64 >= schema["minLength"].as_u64().unwrap_or(0);
    [
        ("type", has_type(&schema["type"], value)),
        ("const", schema.get("const").is_none_or(|only| only == value)),
        ("enum", schema["enum"].as_array().is_none_or(|words| words.contains(value))),
        ("oneOf", some_branch("oneOf")),
        ("anyOf", some_branch("anyOf")),
        ("range", bound("exclusiveMinimum", |number, low| number <= low)),
        ("range", bound("minimum", |number, low| number < low)),
        ("range", bound("maximum", |number, high| number > high)),
        ("items", size("minItems", |count, least| count < least)),
        ("items", size("maxItems", |count, most| count > most)),
        ("minLength", value.as_str().is_none_or(long)),
    ]
    .into_iter()
    .filter(|(_, kept)| !kept)
    .map(|(rule, _)| rule)
    .collect()
}

fn has_type(types: &Value, value: &Value) -> bool {
    let is = |name: &str| match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        "boolean" => value.is_boolean(),
        _ => false,
    };
    match types {
        Value::String(name) => is(name),
        Value::Array(names) => names.iter().filter_map(Value::as_str).any(is),
        _ => true,
    }
}

fn in_table(schema: &Value, table: &Map<String, Value>, path: &str) -> Vec<String> {
    let required = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
    let missing = required.filter(|key| !table.contains_key(*key));
    let mut found: Vec<String> = missing.map(|key| format!("{path}.{key}: missing")).collect();
    let others = schema.get("additionalProperties");
    for (key, inner) in table {
        let path = format!("{path}.{key}");
        match schema["properties"].get(key).or(others) {
            Some(Value::Bool(false)) => found.push(format!("{path}: unknown")),
            Some(schema) => found.extend(breaches(schema, inner, &path)),
            None => {}
        }
    }
    found
}
