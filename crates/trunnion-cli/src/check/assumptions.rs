//! Assumptions about what a program leaves to the machine: rotary solutions and tool changes.

use super::subject::{CheckedMotion, Subject};
use trunnion::machine::RotaryPair;
use trunnion::verify::{Changes, Choice, Choices};

/// Tool directions given instead of rotary positions.
#[derive(Debug, serde::Serialize)]
pub(super) struct AssumedSolutions {
    /// Number of blocks with a vector, and of rotations into tilted planes.
    vectors: usize,
    planes: usize,
    /// Solutions taken, in degrees: at the first vector, at changes of the solution, and at planes.
    places: Vec<AssumedSolution>,
    /// Number of further places that are not listed.
    more: usize,
}

#[derive(Debug, serde::Serialize)]
struct AssumedSolution {
    line: u32,
    /// `vector` or `plane`.
    of: &'static str,
    taken: [f64; 2],
    /// Other solution; null if the tool is parallel to the axis of the first rotary.
    other: Option<[f64; 2]>,
    #[serde(skip)]
    words: String,
}

/// Tool changes after the first move.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub(super) struct ToolChanges {
    count: usize,
    line: u32,
    /// Number of rapid moves not measured, and the line of the first.
    unmeasured: usize,
    first_unmeasured: Option<u32>,
}

impl AssumedSolutions {
    /// Returns the assumptions; `None` if the program leaves nothing open.
    pub(super) fn of(choices: &Choices, subject: &Subject) -> Option<Self> {
        let Choices { vectors, planes, places, more, .. } = choices;
        // Cutter locations have no rotaries to choose.
        let CheckedMotion::Program(_, kinematics) = &subject.motion else { return None };
        let [.., first, second] = &kinematics.machine().axes;
        let words = |of: RotaryPair| {
            let position = |(axis, value): (&trunnion::machine::Axis, f64)| {
                format!("{} {:.3} deg", axis.name, value.to_degrees())
            };
            [first, second]
                .into_iter()
                .zip(<[f64; 2]>::from(of))
                .map(position)
                .collect::<Vec<_>>()
                .join(" ")
        };
        let place = |&Choice { line, plane, taken, other, .. }: &Choice| {
            let degrees = |of: RotaryPair| <[f64; 2]>::from(of).map(f64::to_degrees);
            let beside = other.map_or_else(
                || {
                    "the tool is parallel to the first rotary axis, which keeps its position"
                        .to_owned()
                },
                |other| format!("the other solution is {}", words(other)),
            );
            AssumedSolution {
                line,
                of: if plane { "plane" } else { "vector" },
                taken: degrees(taken),
                other: other.map(degrees),
                words: format!("{}; {beside}", words(taken)),
            }
        };
        let places: Vec<AssumedSolution> = places.iter().map(place).collect();
        (*vectors + *planes > 0).then_some(Self {
            vectors: *vectors,
            planes: *planes,
            places,
            more: *more,
        })
    }

    /// Returns one warning for each place, with the assumption.
    pub(super) fn warnings(&self, program: &str) -> Vec<String> {
        let mut warnings: Vec<String> = self
            .places
            .iter()
            .map(|place| {
                let AssumedSolution { line, of, words, .. } = place;
                format!(
                    "{program}:{line}: for this {of} the rotary axes are assumed to go to {words}: the solution inside travel with the least \
                     motion; the control may choose another"
                )
            })
            .collect();
        // Places beyond the limit of the library are only counted.
        if self.more > 0 {
            warnings.push(format!("{program}: {} more such lines", self.more));
        }
        warnings
    }
}

impl ToolChanges {
    pub(super) fn of(Changes { count, line, unmeasured, first, .. }: Changes) -> Self {
        Self { count, line, unmeasured, first_unmeasured: first }
    }

    /// Returns the warning about rapid moves that were not measured.
    pub(super) fn warnings(&self, program: &str) -> Vec<String> {
        let Self { first_unmeasured, unmeasured, .. } = *self;
        let warning = first_unmeasured.map(|first| {
            format!(
                "{program}:{first}: {unmeasured} rapid moves from this line on are not measured: after a tool change the \
                 position of X, Y and Z is not known until the program commands all three"
            )
        });
        warning.into_iter().collect()
    }
}
