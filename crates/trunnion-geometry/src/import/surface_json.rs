//! Surface JSON: `{"degree":[p,q], "knots":[[..],[..]], "points":[[[x,y,z],..],..],
//! "weights":[[..],..]}`, `points[i][j]` with `i` along u, clamped knots, weights optional, mm.

use super::format::without_mark;
use crate::math::bspline::KnotError;
use crate::surface::NurbsSurface;
use crate::surface::Surface;
use crate::surface::SurfaceError;
use crate::types::{Diagnostic, Diagnostics};
use nalgebra::Point3;
use serde_json::Map;
use serde_json::Value;

/// The keys of a surface file.
const KEYS: [&str; 4] = ["degree", "knots", "points", "weights"];

/// Names at least this alike (Jaro-Winkler) are suggested for each other.
const ALIKE: f64 = 0.7;

/// Faults beyond this number are only counted.
const MOST: usize = 50;

/// Reads a surface from surface JSON.
///
/// # Errors
///
/// All faults found, each with its line and column: syntax, unknown or missing keys, wrong types,
/// wrong numbers of knots or points, weights that are not positive, patches without area.
pub fn read(bytes: &[u8]) -> Result<Surface, Diagnostics> {
    let text = std::str::from_utf8(without_mark(bytes)).map_err(|error| {
        let message = format!("the file is not text (UTF-8) from byte {}", error.valid_up_to());
        vec![Diagnostic::whole(message).with_help("pass a surface JSON or a STEP file")]
    })?;
    let root: Value = serde_json::from_str(text).map_err(|error| vec![syntax(&error)])?;
    let mut reading = Reading { text, faults: Vec::new() };
    let surface = reading.surface(&root);
    match surface {
        Some(surface) if reading.faults.is_empty() => Ok(Surface::Nurbs(surface)),
        _ => {
            // A damaged file may have a fault at every point: the first ones are enough.
            let more = reading.faults.len().saturating_sub(MOST);
            reading.faults.truncate(MOST);
            if more > 0 {
                reading.faults.push(Diagnostic::whole(format!("and {more} more faults")));
            }
            Err(reading.faults.into())
        }
    }
}

/// Text and its faults so far.
struct Reading<'a> {
    text: &'a str,
    faults: Vec<Diagnostic>,
}

impl Reading<'_> {
    /// Notes a fault at a path such as `points[1][0]`.
    fn fault(&mut self, path: &str, message: String, help: &str) {
        let fault = match locate(self.text, path) {
            Some(offset) => Diagnostic::at(self.text, offset, message),
            None => Diagnostic::whole(message),
        };
        self.faults.push(fault.with_help(help));
    }

    fn surface(&mut self, root: &Value) -> Option<NurbsSurface> {
        let Value::Object(map) = root else {
            let message = format!("the file holds {}, not an object", kind(root));
            self.fault("", message, "a surface is {\"degree\": .., \"knots\": .., \"points\": ..}");
            return None;
        };
        self.repeated_keys();
        self.unknown_keys(map);
        let degree = self.required(map, "degree").and_then(|value| self.degrees(value));
        let knots = self.required(map, "knots").and_then(|value| self.knots(value));
        let points = self.required(map, "points").and_then(|value| self.points(value));
        let weights = match map.get("weights") {
            None | Some(Value::Null) => None,
            Some(value) => Some(self.rows(value, "weights", Self::number)?),
        };
        let (degree, knots) = (degree?, knots?);
        // The format is defined for clamped knots; the surface itself would take others.
        self.clamped(degree, &knots);
        let made = NurbsSurface::new(degree, knots, points?, weights);
        made.map_err(|errors| errors.iter().for_each(|error| self.refused(error))).ok()
    }

    /// Notes keys that stand twice: of two equal ones the reader of JSON silently keeps the last.
    fn repeated_keys(&mut self) {
        let mut scan = Scan { bytes: self.text.as_bytes(), at: 0 };
        scan.space();
        let members = scan.members();
        for (at, (key, offset, _)) in members.iter().enumerate() {
            if members.iter().take(at).any(|(other, ..)| other == key) {
                let fault =
                    Diagnostic::at(self.text, *offset, format!("the key `{key}` is given twice"));
                self.faults.push(fault.with_help("keep one of the two"));
            }
        }
    }

    fn unknown_keys(&mut self, map: &Map<String, Value>) {
        for key in map.keys().filter(|key| !KEYS.contains(&key.as_str())) {
            // The most similar key, if it is similar at all, is likely the one that was meant.
            let alike = KEYS.iter().map(|known| (strsim::jaro_winkler(key, known), known));
            let best = alike.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|best| best.0 >= ALIKE);
            let help = match best {
                Some((_, known)) => format!("did you mean `{known}`?"),
                None => format!("known keys: {}", KEYS.join(", ")),
            };
            self.fault(&format!("{key}~key"), format!("unknown key `{key}`"), &help);
        }
    }

    fn required<'v>(&mut self, map: &'v Map<String, Value>, key: &str) -> Option<&'v Value> {
        let value = map.get(key);
        if value.is_none() {
            self.fault("", format!("the key `{key}` is missing"), "");
        }
        value
    }

    fn degrees(&mut self, value: &Value) -> Option<[usize; 2]> {
        let [p, q] = self.pair(value, "degree", "two whole numbers [by u, by v]")?;
        let mut one = |value: &Value, path: &str| {
            let degree = value.as_u64().and_then(|degree| usize::try_from(degree).ok());
            if degree.is_none() {
                let message = format!("`{path}` is {}, not a whole number", shown(value));
                self.fault(path, message, "");
            }
            degree
        };
        let (p, q) = (one(p, "degree[0]"), one(q, "degree[1]"));
        Some([p?, q?])
    }

    fn knots(&mut self, value: &Value) -> Option<[Vec<f64>; 2]> {
        let [u, v] = self.pair(value, "knots", "two lists [by u, by v]")?;
        let u = self.list(u, "knots[0]", Self::number);
        let v = self.list(v, "knots[1]", Self::number);
        Some([u?, v?])
    }

    fn points(&mut self, value: &Value) -> Option<Vec<Vec<Point3<f64>>>> {
        self.rows(value, "points", |reading, value, path| {
            let numbers = reading.list(value, path, Self::number)?;
            let point = <[f64; 3]>::try_from(numbers.as_slice()).ok();
            if point.is_none() {
                let message = format!("`{path}` has {} coordinates, not 3", numbers.len());
                reading.fault(path, message, "");
            }
            point.map(Point3::from)
        })
    }

    fn pair<'v>(&mut self, value: &'v Value, path: &str, need: &str) -> Option<[&'v Value; 2]> {
        if let Some([u, v]) = value.as_array().map(Vec::as_slice) {
            return Some([u, v]);
        }
        let found = match value.as_array() {
            Some(list) => format!("a list of {}", list.len()),
            None => kind(value).to_owned(),
        };
        self.fault(path, format!("`{path}` is {found}; {need} are needed"), "");
        None
    }

    fn rows<T>(
        &mut self,
        value: &Value,
        path: &str,
        item: impl Fn(&mut Self, &Value, &str) -> Option<T> + Copy,
    ) -> Option<Vec<Vec<T>>> {
        self.list(value, path, |reading, row, path| reading.list(row, path, item))
    }

    /// Reads every item, so that all faults are found.
    fn list<T>(
        &mut self,
        value: &Value,
        path: &str,
        item: impl Fn(&mut Self, &Value, &str) -> Option<T>,
    ) -> Option<Vec<T>> {
        let Some(list) = value.as_array() else {
            self.fault(path, format!("`{path}` is {}, not a list", kind(value)), "");
            return None;
        };
        let items: Vec<Option<T>> = list
            .iter()
            .enumerate()
            .map(|(index, value)| item(self, value, &format!("{path}[{index}]")))
            .collect();
        items.into_iter().collect()
    }

    fn number(&mut self, value: &Value, path: &str) -> Option<f64> {
        let number = value.as_f64();
        if number.is_none() {
            self.fault(path, format!("`{path}` is {}, not a number", shown(value)), "");
        }
        number
    }

    /// Notes end knots that are not clamped: the format wants a surface that ends in its corner
    /// points.
    fn clamped(&mut self, degree: [usize; 2], knots: &[Vec<f64>; 2]) {
        for (k, (&degree, knots)) in degree.iter().zip(knots).enumerate() {
            let count = degree.saturating_add(1).min(knots.len());
            let equal =
                |part: &[f64]| part.windows(2).all(|pair| pair[0].total_cmp(&pair[1]).is_eq());
            for (end, part) in [("first", &knots[..count]), ("last", &knots[knots.len() - count..])]
            {
                if !equal(part) {
                    let message = format!("the {end} {count} of `knots[{k}]` differ: {part:?}");
                    self.fault(
                        &format!("knots[{k}]"),
                        message,
                        "repeat the end knots degree + 1 times",
                    );
                }
            }
        }
    }

    /// Notes a fault found when the surface was put together.
    fn refused(&mut self, error: &SurfaceError) {
        let path = match error {
            SurfaceError::Knots { direction, error } => {
                let k = usize::from(*direction == "v");
                match error {
                    KnotError::NotFinite { index, .. } | KnotError::Decreasing { index, .. } => {
                        format!("knots[{k}][{index}]")
                    }
                    KnotError::Degree { .. } => format!("degree[{k}]"),
                    _ => format!("knots[{k}]"),
                }
            }
            SurfaceError::RowLength { what, row, .. } => format!("{what}[{row}]"),
            SurfaceError::NotFinite { what, .. } => what.clone(),
            SurfaceError::Weight { place, .. } => place.clone(),
            _ => "points".to_owned(),
        };
        self.fault(&path, error.to_string(), "");
    }
}

/// Returns a syntax error of `serde_json` as a fault.
fn syntax(error: &serde_json::Error) -> Diagnostic {
    let narrow = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
    let whole = error.to_string();
    // The position is reported apart.
    let message = whole.split(" at line ").next().unwrap_or(&whole).to_owned();
    let help = if error.is_eof() {
        "the file is cut short"
    } else if message.contains("expected value") || message.contains("out of range") {
        "numbers must be finite; JSON knows no NaN and no Infinity"
    } else {
        ""
    };
    let (line, column) = (narrow(error.line()), narrow(error.column()));
    Diagnostic {
        line,
        column,
        message: format!("not valid JSON: {message}"),
        help: help.to_owned(),
    }
}

fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "true or false",
        Value::Number(_) => "a number",
        Value::String(_) => "a text",
        Value::Array(_) => "a list",
        Value::Object(_) => "an object",
    }
}

/// Shows short values as they are written, long ones by kind.
fn shown(value: &Value) -> String {
    match value {
        Value::Number(number) => number.to_string(),
        Value::Bool(_) | Value::Null => value.to_string(),
        _ => kind(value).to_owned(),
    }
}

/// Returns the byte offset of a value in valid JSON: `key[i][j]`; `key~key` for the key itself;
/// empty for the whole. The last of equal keys counts, as for `serde_json`.
fn locate(text: &str, path: &str) -> Option<usize> {
    let mut scan = Scan { bytes: text.as_bytes(), at: 0 };
    scan.space();
    if path.is_empty() {
        return Some(scan.at);
    }
    let (path, of_key) = path.strip_suffix("~key").map_or((path, false), |key| (key, true));
    let (key, indices) =
        if of_key { (path, "") } else { path.split_at(path.find('[').unwrap_or(path.len())) };
    let (name, value) = scan.member(key)?;
    if of_key {
        return Some(name);
    }
    scan.at = value;
    for index in indices.split(['[', ']']).filter(|part| !part.is_empty()) {
        scan.element(index.parse().ok()?)?;
    }
    Some(scan.at)
}

/// A walk over JSON that has been found valid.
struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Scan<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn space(&mut self) {
        while self.peek().is_some_and(|byte| byte.is_ascii_whitespace()) {
            self.at += 1;
        }
    }

    /// Passes a string that starts here.
    fn string(&mut self) {
        self.at += 1;
        while let Some(byte) = self.peek() {
            // A backslash hides the byte behind it, which may be a quote.
            self.at += if byte == b'\\' { 2 } else { 1 };
            if byte == b'"' {
                return;
            }
        }
    }

    /// Passes a value that starts here: brackets are counted, strings skipped.
    fn value(&mut self) {
        let mut depth = 0_usize;
        while let Some(byte) = self.peek() {
            match byte {
                b'"' => self.string(),
                b']' | b'}' | b',' if depth == 0 => return,
                _ => {
                    depth += usize::from(matches!(byte, b'[' | b'{'));
                    depth -= usize::from(matches!(byte, b']' | b'}'));
                    self.at += 1;
                }
            }
        }
    }

    /// Finds the offsets of name and value of the last member `key` of the object that starts here.
    fn member(&mut self, key: &str) -> Option<(usize, usize)> {
        let last = self.members().into_iter().rfind(|(name, ..)| name == key);
        last.map(|(_, name, value)| (name, value))
    }

    /// Lists all members of the object that starts here: name, and offsets of name and value.
    fn members(&mut self) -> Vec<(String, usize, usize)> {
        let mut found = Vec::new();
        self.at += 1;
        self.space();
        while self.peek() == Some(b'"') {
            let offset = self.at;
            self.string();
            // Decoded like a value, so that escapes in a key compare as they read.
            let quoted = self.bytes.get(offset..self.at).unwrap_or_default();
            let name = serde_json::from_slice(quoted).unwrap_or_default();
            self.space();
            self.at += 1;
            self.space();
            found.push((name, offset, self.at));
            self.value();
            self.at += 1;
            self.space();
        }
        found
    }

    /// Moves to an element of the list that starts here.
    fn element(&mut self, index: usize) -> Option<()> {
        if self.peek()? != b'[' {
            return None;
        }
        self.at += 1;
        for _ in 0..index {
            self.value();
            self.at += 1;
        }
        self.space();
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BILINEAR: &str = r#"{"degree": [1, 1], "knots": [[0,0,1,1],[0,0,1,1]],
 "points": [[[0,0,0],[0,9,0]], [[9,0,0],[9,9,1]]]}"#;

    fn faults(text: &str) -> Diagnostics {
        read(text.as_bytes()).unwrap_err()
    }

    #[test]
    fn a_bilinear_patch_is_read() {
        let surface = read(BILINEAR.as_bytes()).unwrap();
        assert_eq!(surface.point(0.5, 0.5), Point3::new(4.5, 4.5, 0.25));
    }

    #[test]
    fn several_faults_are_reported_at_their_places() {
        let text = BILINEAR.replace("\"knots\"", "\"knot\"").replace("[9,0,0]", "[9,\"x\",0]");
        let faults = faults(&text);
        let said: Vec<_> = faults.iter().map(|f| (f.line, f.column, f.message.as_str())).collect();
        assert_eq!(said[0], (1, 20, "unknown key `knot`"));
        assert_eq!(faults[0].help, "did you mean `knots`?");
        assert_eq!(said[1], (1, 1, "the key `knots` is missing"));
        assert_eq!(said[2], (2, 36, "`points[1][0][1]` is a text, not a number"));
    }

    #[test]
    fn wrong_knots_and_weights_are_named() {
        let text = BILINEAR.replacen("[0,0,1,1]", "[0,0,1]", 1);
        let fault = &faults(&text)[0];
        assert!(fault.message.contains("differ"), "{fault:?}");
        assert!(faults(&text)[1].message.contains("3 knots for 2 control points"));
        let weights = BILINEAR.replace('\n', "\"weights\": [[1,1],[-2,1]],\n");
        let fault = &faults(&weights)[0];
        assert!(fault.message.contains("weight -2 at weights[1][0]"), "{fault:?}");
        assert_eq!((fault.line, fault.column), (1, 70));
    }

    #[test]
    fn what_is_no_number_is_refused() {
        assert!(faults(&BILINEAR.replace("9,9,1", "9,NaN,1"))[0].help.contains("finite"));
        assert!(faults(&BILINEAR.replace("9,9,1", "9,1e999,1"))[0].help.contains("finite"));
        assert_eq!(faults("{\"degree\": [1,")[0].help, "the file is cut short");
        assert!(read(&[0xff, 0xfe, 0]).is_err());
    }

    #[test]
    fn a_key_that_stands_twice_is_named() {
        let fault = &faults(&BILINEAR.replace("{\"degree\"", "{\"degree\": [2, 2], \"degree\""))[0];
        assert_eq!(fault.message, "the key `degree` is given twice");
        assert_eq!((fault.line, fault.column), (1, 20));
    }

    #[test]
    fn a_byte_order_mark_is_no_fault() {
        assert!(read(format!("\u{feff}{BILINEAR}").as_bytes()).is_ok());
    }

    #[test]
    fn a_degenerate_patch_is_named() {
        let flat = BILINEAR.replace("[9,0,0],[9,9,1]", "[0,3,0],[0,5,0]");
        assert!(faults(&flat)[0].message.contains("degenerate"), "{:?}", faults(&flat));
    }
}
