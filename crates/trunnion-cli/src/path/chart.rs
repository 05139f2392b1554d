//! Deviation along a path as a drawing.

use super::profile::Profile;
use std::fmt::Write;
use trunnion::types::PoseTolerance;

/// Size of one of the two plots, and the room around them \[px\].
const PLOT: [f64; 2] = [860.0, 150.0];
const MARGIN: [f64; 2] = [80.0, 40.0];

/// Columns: finer than what a screen shows.
const COLUMNS: usize = 860;

/// Draws deviations under their tolerances.
pub(crate) fn draw(profile: &Profile, tolerance: PoseTolerance) -> String {
    let [width, height] = [PLOT[0] + 1.5 * MARGIN[0], 2.0 * (PLOT[1] + 1.75 * MARGIN[1])];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{width}\" height=\"{height}\" \
         fill=\"white\"/>\n"
    );
    let plots = [
        Plot {
            name: "tip, mm",
            tolerance: tolerance.tip,
            columns: profile.columns(COLUMNS, |of| [of.tip, of.tip_bound]),
        },
        Plot {
            name: "axis, deg",
            tolerance: tolerance.axis.to_degrees(),
            columns: profile.columns(COLUMNS, |of| [of.axis, of.axis_bound].map(f64::to_degrees)),
        },
    ];
    for (index, plot) in plots.iter().enumerate() {
        let top = MARGIN[1] + index as f64 * (PLOT[1] + 1.5 * MARGIN[1]);
        plot.draw(&mut svg, top, profile.length());
    }
    svg + "</svg>\n"
}

/// One of the two plots.
struct Plot {
    /// Quantity and unit.
    name: &'static str,
    tolerance: f64,
    /// Deviation seen and its bound, column by column.
    columns: Vec<[f64; 2]>,
}

impl Plot {
    /// Draws the plot with its upper edge at `top` \[px\], for a path of `length` \[mm\].
    fn draw(&self, svg: &mut String, top: f64, length: f64) {
        let Self { name, tolerance, columns } = self;
        let tolerance = *tolerance;
        let [left, bottom] = [MARGIN[0], top + PLOT[1]];
        // A tenth of headroom above the largest value or the tolerance.
        let most = columns.iter().map(|c| c[1]).fold(tolerance, f64::max) * 1.1;
        let y = |value: f64| bottom - value / most * PLOT[1];
        // The bound first, lighter, with the seen deviation on top of it.
        for (part, colour) in [(1, "#9ecae1"), (0, "#08519c")] {
            let _ = write!(svg, "<path fill=\"{colour}\" d=\"M{left:.1},{bottom:.1}");
            for (index, column) in columns.iter().enumerate() {
                let x = left + index as f64;
                let height = y(column[part]);
                let _ = write!(svg, "L{x:.1},{height:.2}L{:.1},{height:.2}", x + 1.0);
            }
            let _ = writeln!(svg, "L{:.1},{bottom:.1}Z\"/>", left + PLOT[0]);
        }
        let right = left + PLOT[0];
        let limit = y(tolerance);
        let _ = writeln!(
            svg,
            "<path d=\"M{left},{top}V{bottom}H{right}\" fill=\"none\" stroke=\"black\"/>\n\
         <path d=\"M{left},{limit:.1}H{right}\" stroke=\"#cb181d\" stroke-dasharray=\"6 4\"/>\n\
         <text x=\"{left}\" y=\"{}\">deviation of the {name}: bounded (light), seen (dark), tolerance (dashed)\
         </text>\n<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{tolerance:.4}</text>\n\
         <text x=\"{}\" y=\"{bottom}\" text-anchor=\"end\">0</text>\n\
         <text x=\"{right}\" y=\"{}\" text-anchor=\"end\">{length:.1} mm along the path</text>",
            top - 8.0,
            left - 6.0,
            limit + 4.0,
            left - 6.0,
            bottom + 16.0
        );
    }
}
