//! The layouts as JSON schema: what `trunnion schema` prints and what the readers check.

use super::job::raw::RawJob;
use super::limits::raw::RawLimits;
use super::machine::raw::RawMachine;
use super::setups::SetupSummary;
use super::summary::Summary;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

/// Layout of the job file.
pub fn job() -> String {
    pretty(&job_value())
}

/// Layout of the machine file.
pub fn machine() -> String {
    pretty(&machine_value())
}

pub(super) fn machine_value() -> Value {
    of::<RawMachine>()
}

/// Layout of the limits file.
pub fn limits() -> String {
    pretty(&limits_value())
}

pub(super) fn limits_value() -> Value {
    of::<RawLimits>()
}

pub(super) fn job_value() -> Value {
    of::<RawJob>()
}

/// Layout of a surface file.
pub fn surface() -> String {
    pretty(&of::<SurfaceFile>())
}

/// Layout of the summary of a run.
pub fn summary() -> String {
    pretty(&of::<Summary>())
}

/// Layout of what a setup search found.
pub fn setup() -> String {
    pretty(&of::<SetupSummary>())
}

/// A tensor-product B-spline or NURBS surface.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "describes the layout; the surface reader has its own types")]
struct SurfaceFile {
    /// Degrees along u and v.
    degree: [u32; 2],
    /// Clamped knot vectors along u and v, every knot written as often as it counts: as many knots
    /// as control points plus degree plus 1, not falling.
    knots: [Vec<f64>; 2],
    /// Control points in mm, points[i][j] = [x, y, z] with i along u and j along v.
    points: Vec<Vec<[f64; 3]>>,
    /// Positive weights, one per control point; all 1 if left out.
    #[serde(default)]
    weights: Option<Vec<Vec<f64>>>,
}

/// Schema of a layout without references, and without `null`, which TOML does not have.
fn of<T: JsonSchema>() -> Value {
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
