//! Error curves as SVG: one location over its circle, several across the feed.

use crate::math;
use crate::positioning::report::trace::{ErrorTrace, TracePoint};
use crate::positioning::request::ToleranceBand;
use std::f64::consts::PI;
use std::fmt::Write;

/// Micrometres per mm: errors are drawn in um.
const MICRO: f64 = 1e3;

/// Colours that stay apart for colour-blind eyes and in print (Okabe and Ito), dark ones first.
const COLOURS: [&str; 9] = [
    "#0b3c5d", "#d55e00", "#009e73", "#cc79a7", "#0072b2", "#7a5c00", "#56b4e9", "#555555",
    "#e0b000",
];

const INK: &str = "#222";

const GRID: &str = "#e3e3e3";

const SHADE: &str = "#d8ecd8";

/// Draws the error of one location: on the left along the strip, on the right round the whole
/// circle, whose higher errors are cut off.
pub fn error_picture(trace: &ErrorTrace, band: ToleranceBand, title: &str) -> String {
    let ToleranceBand { lower, upper } = band;
    let height = upper - lower;
    let from_origin = |angle: f64| (angle - trace.origin).to_degrees();
    let ends = trace.ends.ends().map(from_origin);
    let [low, high] = [ends[0].min(0.0), ends[1]];
    let margin = 0.08 * (high - low);
    let strip = PlotPanel {
        origin: [64.0, 56.0],
        size: [410.0, 250.0],
        x: [low - margin, high + margin],
        y: [lower - 0.25 * height, upper + 0.35 * height].map(|e| e * MICRO),
    };
    let whole = PlotPanel {
        origin: [548.0, 56.0],
        size: [270.0, 250.0],
        x: [-180.0, 180.0],
        y: [lower - 0.5 * height, upper + 4.0 * height].map(|e| e * MICRO),
    };
    let mut svg = open([850.0, 380.0], title);
    let on_strip = |p: &TracePoint| [from_origin(p.angle), p.error * MICRO];
    let around = |p: &TracePoint| [p.angle.to_degrees(), p.error * MICRO];
    let points = || trace.points.iter();
    let kept = |p: &&TracePoint| trace.ends.contains(p.angle);
    strip.frame(
        &mut svg,
        band,
        ["angle on the cutting circle from the first end point, deg", "error, um"],
    );
    for (end, name) in ends.into_iter().zip(["strip begins", "strip ends"]) {
        strip.upright(&mut svg, end, name);
    }
    strip.line(&mut svg, points().map(on_strip), Stroke { colour: COLOURS[0], width: 1.0 });
    strip.line(
        &mut svg,
        points().filter(kept).map(on_strip),
        Stroke { colour: COLOURS[0], width: 2.6 },
    );
    for contact in &trace.contacts {
        strip.dot(&mut svg, [from_origin(*contact), lower * MICRO]);
    }
    whole.frame(&mut svg, band, ["the whole circle, deg from the strip's middle", ""]);
    whole.line(&mut svg, points().map(around), Stroke { colour: COLOURS[0], width: 1.0 });
    whole.line(
        &mut svg,
        points().filter(kept).map(around),
        Stroke { colour: COLOURS[0], width: 2.6 },
    );
    let entries = [
        (COLOURS[0], "error, above zero where material is left; bold on the strip"),
        (SHADE, "tolerance band"),
        (COLOURS[1], "contacts"),
    ];
    legend(&mut svg, [64.0, 366.0], entries.into_iter());
    svg.push_str("</svg>\n");
    svg
}

/// Draws the strips of several methods across the feed, each bold where it keeps the band.
/// Distances are measured from the requested point, to the strip's side.
pub fn comparison_picture(traces: &[ErrorTrace], band: ToleranceBand, title: &str) -> String {
    let ToleranceBand { lower, upper } = band;
    let height = upper - lower;
    let within = |trace: &ErrorTrace, p: &TracePoint| trace.ends.contains(p.angle);
    let strips = traces.iter().flat_map(|t| t.points.iter().filter(move |p| within(t, p)));
    let [low, high] =
        strips.fold([0.0_f64, 0.0_f64], |[low, high], p| [low.min(p.across), high.max(p.across)]);
    let margin = 0.06 * (high - low).max(1e-3);
    let panel = PlotPanel {
        origin: [64.0, 56.0],
        size: [560.0, 300.0],
        x: [low - margin, high + margin],
        y: [lower - 0.3 * height, upper + 1.2 * height].map(|e| e * MICRO),
    };
    let mut svg = open([850.0, 410.0], title);
    panel.frame(
        &mut svg,
        band,
        ["distance across the feed from the surface point, mm", "error, um"],
    );
    panel.upright(&mut svg, 0.0, "place");
    // The first on top; those below it wider, so that equal ones show at its edges.
    let rows = traces.iter().zip(COLOURS.iter().cycle()).enumerate();
    for (row, (trace, colour)) in rows.collect::<Vec<_>>().into_iter().rev() {
        let front = trace.points.iter().filter(|p| p.angle.abs() <= 0.5 * PI);
        let point = |p: &TracePoint| [p.across, p.error * MICRO];
        panel.line(&mut svg, front.clone().map(point), Stroke { colour, width: 0.8 });
        let inside = front.filter(|p| within(trace, p)).map(point);
        panel.line(&mut svg, inside, Stroke { colour, width: 2.0 + 0.8 * row as f64 });
    }
    for (row, (trace, colour)) in traces.iter().zip(COLOURS.iter().cycle()).enumerate() {
        let text = format!("{}: {:.2} mm", trace.name, trace.width);
        let y = 70.0 + 22.0 * row as f64;
        legend(&mut svg, [646.0, y], std::iter::once((*colour, text.as_str())));
    }
    legend(&mut svg, [646.0, 350.0], std::iter::once((SHADE, "tolerance band")));
    svg.push_str("</svg>\n");
    svg
}

/// Swatches with names, in a row.
fn legend<'a>(
    svg: &mut String,
    [mut x, y]: [f64; 2],
    entries: impl Iterator<Item = (&'a str, &'a str)>,
) {
    for (colour, text) in entries {
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"18\" height=\"8\" fill=\"{colour}\"/>\
             <text x=\"{:.1}\" y=\"{y:.1}\">{}</text>",
            y - 8.0,
            x + 24.0,
            escaped(text)
        );
        // A letter of this size is some 6.3 px wide.
        x += 50.0 + 6.3 * text.chars().count() as f64;
    }
}

fn open([width, height]: [f64; 2], title: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"12\" fill=\"{INK}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <text x=\"64\" y=\"28\" font-size=\"15\">{}</text>\n",
        escaped(title)
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

/// Colour and width \[px\] of a curve.
#[derive(Clone, Copy)]
struct Stroke<'a> {
    colour: &'a str,
    width: f64,
}

/// Rectangle with axes.
struct PlotPanel {
    /// Upper left corner \[px\].
    origin: [f64; 2],
    /// Width and height \[px\].
    size: [f64; 2],
    /// Range of the abscissas.
    x: [f64; 2],
    /// Range of the ordinates.
    y: [f64; 2],
}

impl PlotPanel {
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let share = |value: f64, [low, high]: [f64; 2]| (value - low) / (high - low);
        [
            self.origin[0] + self.size[0] * share(x, self.x),
            self.origin[1] + self.size[1] * (1.0 - share(y, self.y)),
        ]
    }

    /// Draws the tolerance band.
    fn shade(&self, svg: &mut String, band: ToleranceBand) {
        let [left, top] = self.place([self.x[0], band.upper * MICRO]);
        let [right, bottom] = self.place([self.x[1], band.lower * MICRO]);
        let _ = writeln!(
            svg,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{SHADE}\"/>",
            right - left,
            bottom - top
        );
    }

    /// Draws a dashed line across the panel, with a name above it.
    fn upright(&self, svg: &mut String, x: f64, name: &str) {
        let [x, _] = self.place([x, 0.0]);
        let [top, bottom] = [self.origin[1], self.origin[1] + self.size[1]];
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} {top:.1}V{bottom:.1}\" stroke=\"#777\" stroke-dasharray=\"4 3\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{name}</text>",
            top - 6.0
        );
    }

    /// Draws a curve, clipped to the panel.
    fn line(
        &self,
        svg: &mut String,
        points: impl Iterator<Item = [f64; 2]>,
        Stroke { colour, width }: Stroke,
    ) {
        let points: Vec<[f64; 2]> = points.collect();
        let mut runs: Vec<Vec<[f64; 2]>> = Vec::new();
        let mut joined = false;
        for pair in points.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let Some(([a, b], whole)) = self.clipped([from, to]) else {
                joined = false;
                continue;
            };
            match runs.last_mut().filter(|_| joined) {
                Some(run) => run.push(b),
                None => runs.push(vec![a, b]),
            }
            joined = whole;
        }
        for run in runs {
            let place = |point: &[f64; 2]| {
                let [x, y] = self.place(*point);
                format!("{x:.1},{y:.1}")
            };
            let places: Vec<String> = run.iter().map(place).collect();
            let _ = writeln!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"/>",
                places.join(" ")
            );
        }
    }

    /// Clips a segment to the panel. Returns the part inside, and `true` if it goes on to the end of
    /// the segment.
    fn clipped(&self, [from, to]: [[f64; 2]; 2]) -> Option<([[f64; 2]; 2], bool)> {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for (k, range) in [self.x, self.y].into_iter().enumerate() {
            let way = to[k] - from[k];
            // Liang and Barsky: each border cuts the range of the parameter from one side.
            for (wall, sign) in [(range[0], 1.0), (range[1], -1.0)] {
                let (gap, rise) = (sign * (wall - from[k]), sign * way);
                if rise > 0.0 {
                    enter = enter.max(gap / rise);
                } else if rise < 0.0 {
                    leave = leave.min(gap / rise);
                } else if gap > 0.0 {
                    return None;
                }
            }
        }
        let at = |t: f64| {
            let between = |k: usize| from[k] + t * (to[k] - from[k]);
            if t >= 1.0 { to } else { [between(0), between(1)] }
        };
        (enter < leave).then(|| ([at(enter), at(leave)], leave >= 1.0))
    }

    /// Draws a contact, with its abscissa.
    fn dot(&self, svg: &mut String, point: [f64; 2]) {
        let [x, y] = self.place(point);
        let _ = writeln!(
            svg,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"{}\"/><text x=\"{x:.1}\" y=\"{:.1}\" \
             text-anchor=\"middle\">{:.1}</text>",
            COLOURS[1],
            y + 18.0,
            point[0]
        );
    }

    /// Draws tolerance band, border, ticks and names of the axes.
    fn frame(&self, svg: &mut String, band: ToleranceBand, [x_name, y_name]: [&str; 2]) {
        self.shade(svg, band);
        let [left, top] = self.origin;
        let [width, height] = self.size;
        let bottom = top + height;
        for tick in ticks(self.x, 9.0) {
            let [x, _] = self.place([tick, 0.0]);
            let _ = writeln!(
                svg,
                "<path d=\"M{x:.1} {bottom:.1}v5\" stroke=\"{INK}\"/><text x=\"{x:.1}\" y=\"{:.1}\" \
                 text-anchor=\"middle\">{}</text>",
                bottom + 18.0,
                label(tick)
            );
        }
        for tick in ticks(self.y, 8.0) {
            let [_, y] = self.place([0.0, tick]);
            let _ = writeln!(
                svg,
                "<path d=\"M{left:.1} {y:.1}h{width:.1}\" stroke=\"{GRID}\" stroke-opacity=\"0.8\"/>\
                 <path d=\"M{left:.1} {y:.1}h-5\" stroke=\"{INK}\"/><text x=\"{:.1}\" y=\"{:.1}\" \
                 text-anchor=\"end\">{}</text>",
                left - 8.0,
                y + 4.0,
                label(tick)
            );
        }
        let _ = writeln!(
            svg,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" \
             fill=\"none\" stroke=\"{INK}\"/>\n<text x=\"{:.1}\" y=\"{:.1}\" \
             text-anchor=\"middle\">{x_name}</text>",
            left + 0.5 * width,
            bottom + 36.0
        );
        if !y_name.is_empty() {
            let [x, y] = [left - 44.0, top + 0.5 * height];
            let _ = writeln!(
                svg,
                "<text transform=\"translate({x:.1} {y:.1}) rotate(-90)\" \
                 text-anchor=\"middle\">{y_name}</text>"
            );
        }
    }
}

/// Returns the multiples of 1, 2 or 5 times a power of ten in a range, `most` of them or fewer.
fn ticks([low, high]: [f64; 2], most: f64) -> Vec<f64> {
    let least = ((high - low) / most).max(f64::MIN_POSITIVE);
    let power = math::powf(10.0, math::log10(least).floor());
    // Degrees are read in quarters of a turn.
    let quarter = (high - low - 360.0).abs() < 1e-9;
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    let step =
        if quarter { 90.0 } else { steps.into_iter().find(|s| *s >= least).unwrap_or(least) };
    let (first, last) = ((low / step).ceil(), (high / step).floor());
    let count = (last - first).clamp(0.0, 50.0);
    (0..=50).map(f64::from).take_while(|k| *k <= count).map(|k| (first + k) * step).collect()
}

/// Formats a tick without the digits that rounding makes, and without a minus before zero.
fn label(tick: f64) -> String {
    let text = format!("{tick:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(ticks([-3.5, 13.2], 9.0), [-2.0, 0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0]);
        assert_eq!(ticks([-180.0, 180.0], 9.0), [-180.0, -90.0, 0.0, 90.0, 180.0]);
        assert_eq!(label(-0.0), "0");
        assert_eq!(label(2.5), "2.5");
        assert_eq!(label(100.0), "100");
    }

    #[test]
    fn curves_end_at_the_border() {
        let panel = PlotPanel { origin: [0.0; 2], size: [1.0; 2], x: [0.0, 10.0], y: [0.0, 1.0] };
        let part = panel.clipped([[0.0, 0.0], [2.0, 2.0]]);
        assert_eq!(part, Some(([[0.0, 0.0], [1.0, 1.0]], false)));
        assert_eq!(panel.clipped([[0.0, 2.0], [2.0, 3.0]]), None);
        let mut svg = String::new();
        let points = [[0.0, 2.0], [2.0, 0.0], [4.0, 2.0], [6.0, 2.0], [8.0, 0.5]];
        panel.line(&mut svg, points.into_iter(), Stroke { colour: "#000", width: 1.0 });
        assert_eq!(svg.matches("<polyline").count(), 2, "{svg}");
    }
}
