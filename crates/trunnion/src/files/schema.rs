//! The layouts as JSON schemas, which `trunnion schema` prints and the readers check.

use super::job::raw::RawJob;
use super::library::raw::RawLibrary;
use super::limits::raw::RawLimits;
use super::machine::raw::RawMachine;
use super::setups::SetupSummary;
use super::summary::Summary;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

/// Returns the layout of the job file.
pub fn job() -> String {
    pretty(&job_value())
}

/// Returns the layout of the machine file.
pub fn machine() -> String {
    pretty(&machine_value())
}

pub(super) fn machine_value() -> Value {
    of::<RawMachine>()
}

/// Returns the layout of a library of cutters, holders and machines.
pub fn library() -> String {
    pretty(&library_value())
}

pub(super) fn library_value() -> Value {
    of::<RawLibrary>()
}

/// Returns the layout of the limits file.
pub fn limits() -> String {
    pretty(&limits_value())
}

pub(super) fn limits_value() -> Value {
    of::<RawLimits>()
}

pub(super) fn job_value() -> Value {
    of::<RawJob>()
}

/// Returns the layout of a surface file.
pub fn surface() -> String {
    pretty(&of::<SurfaceFile>())
}

/// Returns the layout of the summary of a run.
pub fn summary() -> String {
    pretty(&of::<Summary>())
}

/// Returns the layout of the result of a setup search.
pub fn setup() -> String {
    pretty(&of::<SetupSummary>())
}

/// Tensor-product B-spline or NURBS surface.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "describes the layout; the surface reader has its own types")]
struct SurfaceFile {
    /// Degrees along u and v.
    degree: [u32; 2],
    /// Clamped knot vectors along u and v, not falling; every knot is repeated by its multiplicity, so that there are
    /// as many as control points plus degree plus 1.
    knots: [Vec<f64>; 2],
    /// Control points in mm, points[i][j] = [x, y, z] with i along u and j along v.
    points: Vec<Vec<[f64; 3]>>,
    /// Positive weights, one per control point. Default: all 1.
    #[serde(default)]
    weights: Option<Vec<Vec<f64>>>,
}

/// Returns the schema of a layout without references, and without `null`, which TOML does not have.
fn of<T: JsonSchema>() -> Value {
    // Inlined subschemas let the walk follow a key without resolving references.
    let settings =
        SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<T>().to_value();
    drop_null(&mut schema);
    schema
}

fn drop_null(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            if let Some(Value::Array(types)) = map.get_mut("type") {
                types.retain(|name| name != "null");
                // A list of one type is shorter as a word.
                if let [only] = types.as_slice() {
                    let only = only.clone();
                    map.insert("type".into(), only);
                }
            }
            if map.get("default").is_some_and(Value::is_null) {
                map.remove("default");
            }
            for key in ["anyOf", "oneOf"] {
                if let Some(Value::Array(branches)) = map.get_mut(key) {
                    branches.retain(|branch| branch.get("type").is_none_or(|name| name != "null"));
                    // A choice of one is no choice: its keys move up, without replacing the
                    // description that the field itself has.
                    if let [Value::Object(only)] = branches.as_slice() {
                        let only = only.clone();
                        map.remove(key);
                        for (key, value) in only {
                            map.entry(key).or_insert(value);
                        }
                    }
                }
            }
            map.values_mut().for_each(drop_null);
        }
        Value::Array(items) => items.iter_mut().for_each(drop_null),
        _ => {}
    }
}

fn pretty(schema: &Value) -> String {
    let mut text = format!("{schema:#}");
    text.push('\n');
    text
}
