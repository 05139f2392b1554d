//! What a check says of what the program leaves to the machine.

use super::subject::{Motion, Subject};
use trunnion::verify::{Changes, Choice, Choices};

/// Directions instead of rotaries.
#[derive(Debug, serde::Serialize)]
pub(super) struct AssumedSolutions {
    /// Blocks with a vector, and turns into tilted planes.
    vectors: usize,
    planes: usize,
    /// Where which solution was taken, in degrees: the first vector, changes of the solution after it, planes.
    places: Vec<AssumedSolution>,
    /// Places that are left out.
    more: usize,
}

#[derive(Debug, serde::Serialize)]
struct AssumedSolution {
    line: u32,
    /// `vector` or `plane`.
    of: &'static str,
    taken: [f64; 2],
    /// Null where the tool stands along the first rotary's axis.
    other: Option<[f64; 2]>,
    #[serde(skip)]
    words: String,
}

/// Tool changes behind the first move.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub(super) struct ToolChanges {
    count: usize,
    line: u32,
    /// Rapid moves that were not measured, and the line of the first.
    unmeasured: usize,
    first_unmeasured: Option<u32>,
}

impl AssumedSolutions {
    /// `None` where nothing is left open.
    pub(super) fn of(choices: &Choices, subject: &Subject) -> Option<Self> {
        let Choices { vectors, planes, places, more } = choices;
        let Motion::Program(_, kinematics) = &subject.motion else { return None };
        let [.., first, second] = &kinematics.machine().axes;
        let words = |of: [f64; 2]| {
            let told = |(axis, value): (&trunnion::machine::Axis, f64)| {
                format!("{} {:.3} deg", axis.name, value.to_degrees())
            };
            [first, second].into_iter().zip(of).map(told).collect::<Vec<_>>().join(" ")
        };
        let place = |&Choice { line, plane, taken, other }: &Choice| {
            let degrees = |of: [f64; 2]| of.map(f64::to_degrees);
            let beside = other.map_or_else(
                || "the tool stands along the first axis, which stays".to_owned(),
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

    /// For people: each place, and what is assumed.
    pub(super) fn warnings(&self, program: &str) -> Vec<String> {
        let mut told: Vec<String> = self
            .places
            .iter()
            .map(|place| {
                let AssumedSolution { line, of, words, .. } = place;
                format!(
                    "{program}:{line}: by this {of} the rotaries are taken to go to {words}: that with the least travel, inside \
                     travel; the control may choose otherwise"
                )
            })
            .collect();
        if self.more > 0 {
            told.push(format!("{program}: {} more such places", self.more));
        }
        told
    }
}

impl ToolChanges {
    pub(super) fn of(Changes { count, line, unmeasured, first }: Changes) -> Self {
        Self { count, line, unmeasured, first_unmeasured: first }
    }

    /// For people.
    pub(super) fn warnings(&self, program: &str) -> Vec<String> {
        let Self { first_unmeasured, unmeasured, .. } = *self;
        let told = first_unmeasured.map(|first| {
            format!(
                "{program}:{first}: {unmeasured} rapid moves were not measured, from here on: where a tool change leaves X, Y and Z \
                 is the machine's own, until the program tells all three"
            )
        });
        told.into_iter().collect()
    }
}
