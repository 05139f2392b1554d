//! A drawing of the chain: the axes in space with all of them at zero, and in a row from workpiece
//! to tool.

use super::checked::{Axis, FIRST_ROTARY, Machine};
use super::describe::{MovedBody, direction};
use super::spec::AxisKind;
use crate::math;
use crate::types::AXES;
use nalgebra::{Point3, UnitVector3, Vector3};
use std::f64::consts::TAU;
use std::fmt::Write;

/// Size of the drawing, of its view in space, and of the row below \[px\].
const WIDTH: f64 = 1040.0;
const VIEW: f64 = 560.0;
const TOP: f64 = 70.0;
const HEIGHT: f64 = TOP + VIEW + 190.0;

const STYLE: &str = "<style>
text{font:14px sans-serif;fill:#1f2933}.title{font-size:20px;font-weight:600}.note{font-size:12px;fill:#52606d}
.name{font-size:20px;font-weight:600}.part{stroke:#1864ab;fill:none}.tool{stroke:#c2410c;fill:none}
.halo{paint-order:stroke;stroke:#fff;stroke-width:5px;stroke-linejoin:round}
text.part{fill:#1864ab;stroke:#fff}text.tool{fill:#c2410c;stroke:#fff}
.travel{stroke:#9aa5b1;stroke-dasharray:3 4;fill:none}.bed{fill:#e4e7eb;stroke:#7b8794}
.partbox{fill:#e7f5ff;stroke:#1864ab}.toolbox{fill:#fff4e6;stroke:#c2410c}
</style>";

/// Draws the chain of a machine as SVG: axis lines, directions in which the machine really moves when an
/// axis counts up, travel of the spindle nose; below it the chain from workpiece to tool.
pub fn picture(machine: &Machine) -> String {
    let mut svg = Svg::new();
    let kind = machine.kind().name();
    let layout = machine.layout().map_or(String::new(), |code| format!(", layout {code}"));
    svg.text([24.0, 34.0], "title", "start", &format!("{}: {kind}{layout}", machine.name));
    svg.text(
        [24.0, 56.0],
        "note",
        "start",
        "machine frame with z up, all axes at zero; arrows: how the machine moves when the axis counts up; dashed box: travel of the spindle nose",
    );
    let view = View::new(machine);
    travel_box(&mut svg, &view, machine);
    tool(&mut svg, &view, machine);
    for (index, axis) in machine.axes.iter().enumerate() {
        if axis.kind == AxisKind::Rotary {
            rotary(&mut svg, &view, axis, class(machine.body(index)));
        }
    }
    triad(&mut svg, machine);
    row(&mut svg, machine);
    svg.end()
}

/// Position of the name of an axis on its line, beyond the arc \[units of the view\].
const LABEL: f64 = 1.4;

/// Text of a drawing.
struct Svg {
    text: String,
}

impl Svg {
    fn new() -> Self {
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\">\n{STYLE}\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        );
        Self { text }
    }

    fn end(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    /// Adds an element; writing to a string cannot fail.
    fn add(&mut self, element: std::fmt::Arguments<'_>) {
        let _ = self.text.write_fmt(element);
        self.text.push('\n');
    }

    fn text(&mut self, [x, y]: [f64; 2], class: &str, anchor: &str, words: &str) {
        let words = words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        self.add(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" class=\"{class}\" text-anchor=\"{anchor}\">{words}</text>"
        ));
    }

    fn line(&mut self, points: &[[f64; 2]], class: &str, width: f64, extra: &str) {
        let list: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        self.add(format_args!(
            "<polyline points=\"{}\" class=\"{class}\" stroke-width=\"{width}\" stroke-linecap=\"round\" {extra}/>",
            list.join(" ")
        ));
    }

    /// Draws the head of an arrow that ends at `tip`, coming from `from`.
    fn head(&mut self, from: [f64; 2], tip: [f64; 2], class: &str) {
        const LENGTH: f64 = 11.0;
        let [dx, dy] = [tip[0] - from[0], tip[1] - from[1]];
        let size = math::hypot(dx, dy);
        if size <= 0.0 {
            return;
        }
        // Back from the tip along the arrow, and to both sides by 0.45 of that.
        let [ux, uy] = [dx / size * LENGTH, dy / size * LENGTH];
        let side = |s: f64| [tip[0] - ux - s * 0.45 * uy, tip[1] - uy + s * 0.45 * ux];
        self.line(&[side(1.0), tip, side(-1.0)], class, 2.5, "");
    }
}

/// Parallel projection of the machine frame, seen from the front right above.
struct View {
    right: Vector3<f64>,
    up: Vector3<f64>,
    scale: f64,
    middle: [f64; 2],
    /// Length for drawing that has no size of its own \[mm\].
    unit: f64,
}

impl View {
    fn new(machine: &Machine) -> Self {
        // Orthonormal frame of the projection: towards the viewer, right, and up with z upright.
        let toward = Vector3::new(0.52, -0.72, 0.46).normalize();
        let right = Vector3::z().cross(&toward).normalize();
        let up = toward.cross(&right);
        let mut points: Vec<Point3<f64>> = corners(machine).to_vec();
        points.push(machine.gauge);
        points.extend(machine.axes.iter().skip(FIRST_ROTARY).map(|axis| axis.point));
        // Arcs and labels are as large as a share of the machine.
        let size = extent(&points).norm();
        let unit = if size > 0.0 { 0.16 * size } else { 1.0 };
        for axis in machine.axes.iter().skip(FIRST_ROTARY) {
            points.extend([1.0, -1.0].map(|side| axis.point + axis.dir.scale(LABEL * side * unit)));
        }
        points.push(machine.gauge - machine.tool_axis.scale(unit));
        let flat = |row: &Vector3<f64>| {
            let all = points.iter().map(|point| row.dot(&point.coords));
            all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
        };
        // The largest scale at which all points fit into the view.
        let [[left, far], [bottom, top]] = [flat(&right), flat(&up)];
        let room = |span: f64, size: f64| if span > 0.0 { size / span } else { f64::INFINITY };
        let scale = room(far - left, WIDTH - 320.0).min(room(top - bottom, VIEW - 60.0));
        let scale = if scale.is_finite() { scale } else { 1.0 };
        Self { right, up, scale, middle: [0.5 * (left + far), 0.5 * (bottom + top)], unit }
    }

    fn at(&self, point: &Point3<f64>) -> [f64; 2] {
        // SVG counts y downwards.
        let [x, y] = [self.right.dot(&point.coords), self.up.dot(&point.coords)];
        [
            0.5 * WIDTH + (x - self.middle[0]) * self.scale,
            TOP + 0.5 * VIEW - (y - self.middle[1]) * self.scale,
        ]
    }
}

fn extent(points: &[Point3<f64>]) -> Vector3<f64> {
    let fold = |start: f64, pick: fn(f64, f64) -> f64| {
        points.iter().fold(Vector3::repeat(start), |sum, point| sum.zip_map(&point.coords, pick))
    };
    fold(f64::NEG_INFINITY, f64::max) - fold(f64::INFINITY, f64::min)
}

/// Returns the corners of the region that the nose reaches relative to the part with the rotaries at zero;
/// bit `k` of the index is the end of travel of axis `k`.
fn corners(machine: &Machine) -> [Point3<f64>; 8] {
    std::array::from_fn(|corner| {
        let along = machine.axes.iter().take(FIRST_ROTARY).enumerate().map(|(index, axis)| {
            let [low, high] = axis.limits.ends();
            let value = if corner >> index & 1 == 1 { high } else { low };
            axis.dir.scale(axis.sense * value)
        });
        machine.gauge + along.sum::<Vector3<f64>>()
    })
}

fn class(body: MovedBody) -> &'static str {
    match body {
        MovedBody::Part => "part",
        MovedBody::Tool => "tool",
    }
}

fn travel_box(svg: &mut Svg, view: &View, machine: &Machine) {
    let corners = corners(machine);
    for (index, from) in corners.iter().enumerate() {
        for bit in [1, 2, 4] {
            // Edges join corners whose indices differ in one bit; each is drawn once, from the lower index.
            if let (0, Some(to)) = (index & bit, corners.get(index | bit)) {
                svg.line(&[view.at(from), view.at(to)], "travel", 1.2, "");
            }
        }
    }
}

/// Draws the spindle nose and a tool of no particular length.
fn tool(svg: &mut Svg, view: &View, machine: &Machine) {
    let along = |by: f64| view.at(&(machine.gauge + machine.tool_axis.scale(by * view.unit)));
    svg.line(&[along(0.0), along(0.55)], "tool", 16.0, "opacity=\"0.35\"");
    svg.line(&[along(0.0), along(-0.45)], "tool", 6.0, "");
    let [x, y] = along(0.0);
    svg.add(format_args!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"#c2410c\"/>"));
    let [_, end] = along(-0.45);
    svg.text([x - 12.0, end + 4.0], "note halo", "end", "spindle nose (gauge point) and tool");
}

/// Draws an axis line, an arc that turns the way the machine does, and the name at the end of the line.
fn rotary(svg: &mut Svg, view: &View, axis: &Axis, class: &str) {
    let along = |by: f64| axis.point + axis.dir.scale(by * view.unit);
    svg.line(
        &[view.at(&along(-1.1)), view.at(&along(1.1))],
        class,
        2.0,
        "stroke-dasharray=\"14 4 3 4\"",
    );
    let [x, y] = view.at(&axis.point);
    svg.add(format_args!(
        "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" class=\"{class}\" fill=\"#fff\"/>"
    ));
    // +q turns the tool relative to the part: a table turns the other way.
    let turning = if class == "part" { -axis.sense } else { axis.sense };
    let around = axis.dir.scale(turning);
    // Any direction not along the axis gives a frame for the arc of three quarters of a turn.
    let side = if axis.dir.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let first = axis.dir.cross(&side).normalize();
    let second = around.cross(&first);
    let center = along(0.8);
    let arc: Vec<[f64; 2]> = (0..=40)
        .map(|step| {
            let (sin, cos) = math::sin_cos(f64::from(step) / 40.0 * 0.75 * TAU);
            view.at(&(center + (first * cos + second * sin) * (0.32 * view.unit)))
        })
        .collect();
    svg.line(&arc, class, 2.5, "");
    // The head follows the chord of the last two steps, which is nearly the tangent.
    if let [.., from, _, tip] = arc.as_slice() {
        svg.head(*from, *tip, class);
    }
    let [x, y] = view.at(&along(LABEL));
    let [start_x, _] = view.at(&along(1.0));
    let anchor = if x > start_x + 8.0 {
        "start"
    } else if x < start_x - 8.0 {
        "end"
    } else {
        "middle"
    };
    svg.text([x, y - 2.0], &format!("name halo {class}"), anchor, &axis.name);
    let lower = if anchor == "middle" { [x + 16.0, y - 4.0] } else { [x, y + 15.0] };
    let anchor = if anchor == "middle" { "start" } else { anchor };
    svg.text(lower, "note halo", anchor, &travel(axis));
}

/// Draws the directions of the linear axes as the machine moves, in the lower left corner.
fn triad(svg: &mut Svg, machine: &Machine) {
    const LENGTH: f64 = 62.0;
    let view = View { scale: LENGTH, middle: [0.0; 2], ..View::new(machine) };
    let origin = [118.0, TOP + VIEW - 78.0];
    let place = |v: Vector3<f64>| {
        let [x, y] = view.at(&Point3::from(v));
        [x - 0.5 * WIDTH + origin[0], y - TOP - 0.5 * VIEW + origin[1]]
    };
    for (index, axis) in machine.axes.iter().take(FIRST_ROTARY).enumerate() {
        let body = machine.body(index);
        let sign = if body == MovedBody::Part { -axis.sense } else { axis.sense };
        let towards = axis.dir.scale(sign);
        let (start, tip) = (place(Vector3::zeros()), place(towards));
        svg.line(&[start, tip], class(body), 2.5, "");
        svg.head(start, tip, class(body));
        let [x, y] = place(towards * 1.28);
        svg.text([x, y + 6.0], &format!("name halo {}", class(body)), "middle", &axis.name);
    }
}

/// Formats the travel of an axis: `-35 .. 120 deg`, `endless`.
fn travel(axis: &Axis) -> String {
    let (unit, factor) = match axis.kind {
        AxisKind::Linear => ("mm", 1.0),
        AxisKind::Rotary => ("deg", 1.0_f64.to_degrees()),
    };
    let [low, high] = axis.limits.ends().map(|end| (end * factor * 1e3).round() / 1e3);
    if low.is_finite() { format!("{low} .. {high} {unit}") } else { "endless".to_owned() }
}

/// Draws the chain as boxes from workpiece to tool.
fn row(svg: &mut Svg, machine: &Machine) {
    const GAP: f64 = 16.0;
    let top = TOP + VIEW + 46.0;
    // Five axes, workpiece, bed and tool.
    let count = AXES as f64 + 3.0;
    let width = (WIDTH - 48.0 - (count - 1.0) * GAP) / count;
    svg.text([24.0, top - 16.0], "", "start", "the chain, from workpiece over the bed to tool");
    for (place, word) in machine.chain.iter().enumerate() {
        let left = 24.0 + place as f64 * (width + GAP);
        let middle = left + 0.5 * width;
        let axis = machine.index_of(word);
        let body = axis.map(|index| machine.body(index));
        let class = match (word.as_str(), body) {
            ("b", _) => "bed",
            ("w", _) | (_, Some(MovedBody::Part)) => "partbox",
            _ => "toolbox",
        };
        if place > 0 {
            let y = top + 45.0;
            svg.line(&[[left - GAP, y], [left, y]], "travel", 2.0, "");
        }
        svg.add(format_args!(
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"90\" rx=\"8\" class=\"{class}\" stroke-width=\"1.5\"/>"
        ));
        let found = axis.and_then(|index| machine.axes.get(index));
        let [name, first, second] = match (word.as_str(), found) {
            (_, Some(axis)) => described(axis),
            ("w", _) => ["part".into(), String::new(), String::new()],
            ("b", _) => ["bed".into(), "stands still".into(), String::new()],
            _ => ["tool".into(), "axis".into(), direction(&machine.tool_axis)],
        };
        svg.text([middle, top + 32.0], "name", "middle", &name);
        svg.text([middle, top + 56.0], "note", "middle", &first);
        svg.text([middle, top + 74.0], "note", "middle", &second);
    }
    let legend = "blue moves the part, orange the tool; +q is the motion of the tool relative to the part (ISO 841), so a blue axis moves against its count";
    svg.text([24.0, top + 116.0], "note", "start", legend);
}

/// Returns the three lines of an axis' box: name, direction and travel.
fn described(axis: &Axis) -> [String; 3] {
    let towards = UnitVector3::new_unchecked(axis.dir.scale(axis.sense));
    let verb = match axis.kind {
        AxisKind::Linear => "along",
        AxisKind::Rotary => "about",
    };
    let towards = direction(&towards);
    // Components fill a box by themselves.
    let line = if towards.len() > 2 { towards } else { format!("{verb} {towards}") };
    [axis.name.clone(), line, travel(axis)]
}

#[cfg(test)]
mod tests {
    use super::super::samples::ac_trunnion;
    use super::*;

    #[test]
    fn a_drawing_names_every_axis_and_is_well_formed() {
        let mut spec = ac_trunnion();
        spec.name = "a < b & c".to_owned();
        let svg = picture(&Machine::new(spec).unwrap());
        assert!(svg.contains("a &lt; b &amp; c: table-table, layout 23"));
        for name in ["X", "Y", "Z", "A", "C"] {
            assert!(svg.matches(&format!(">{name}</text>")).count() == 2, "{name}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
