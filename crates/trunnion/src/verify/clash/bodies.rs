//! Bodies of a machine as closed meshes on its links.

use super::linked::{LinkedBody, placed};
use super::pair::BodyPair;
use crate::machine::{BodyShape, Machine, MachineBody};
use crate::types::{AxisVector, Mesh};
use crate::verify::error::VerifyError;
use crate::verify::fixture::obstacle::Fixture;
use crate::verify::stock::build::solid::Solid;
use crate::verify::swept::revolved::revolved;
use nalgebra::{UnitVector3, Vector3};
use std::f64::consts::PI;

/// Two bodies that may touch, which are not compared.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct BodyMeeting {
    /// Names of both.
    pub bodies: [String; 2],
    /// Reason why they are left out.
    pub why: &'static str,
}

/// Bodies of a machine, and the pairs of them that are compared.
#[derive(Debug)]
pub struct MachineBodies {
    pub(crate) all: Vec<LinkedBody>,
    pub(crate) pairs: Vec<[usize; 2]>,
    /// Solids on the workpiece, in its frame.
    pub(crate) held: Vec<HeldBody>,
    left_out: Vec<BodyMeeting>,
    tolerance: f64,
}

/// Solid that rides on the workpiece.
#[derive(Debug)]
pub(crate) struct HeldBody {
    pub(crate) name: String,
    pub(crate) mesh: Mesh,
    pub(crate) allowance: f64,
    pub(crate) role: HeldRole,
}

/// Part that a solid on the workpiece plays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum HeldRole {
    /// It keeps its shape.
    Fixture,
    /// The program cuts it.
    Stock,
}

/// Name of the stock in findings.
pub(crate) const STOCK: &str = "stock";

/// Positions of every axis at which two bodies that touch at home are compared: a share of the travel.
const SHARES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

impl MachineBodies {
    /// Builds the bodies of a machine; `None` if it has none. Cylinders become prisms around them, larger by at most
    /// `tolerance` \[mm\].
    ///
    /// Bodies of one link are not compared, nor are those that the machine file lets touch, nor those that touch at home
    /// and wherever the axes between them are.
    ///
    /// # Errors
    ///
    /// [`VerifyError::Bodies`] for a body whose file was not read, that is not closed, or that runs into another one at home.
    pub fn new(machine: &Machine, tolerance: f64) -> Result<Option<Self>, VerifyError> {
        if machine.bodies.is_empty() {
            return Ok(None);
        }
        let all: Result<Vec<LinkedBody>, VerifyError> =
            machine.bodies.iter().map(|body| linked(machine, body, tolerance)).collect();
        let mut bodies = Self {
            all: all?,
            pairs: Vec::new(),
            held: Vec::new(),
            left_out: Vec::new(),
            tolerance,
        };
        for first in 0..bodies.all.len() {
            for second in first + 1..bodies.all.len() {
                bodies.add(machine, [first, second], tolerance)?;
            }
        }
        Ok(Some(bodies))
    }

    /// Adds a fixture, in the workpiece frame; it may stand out beyond its triangles by `allowance` \[mm\]. It is
    /// compared with all bodies but those that carry it.
    pub fn hold(&mut self, name: &str, solid: &Solid, allowance: f64) {
        self.enter(name, solid, allowance, HeldRole::Fixture);
    }

    /// Adds the uncut stock, in the workpiece frame. A check that cuts it takes it as it is cut so far; any other check takes
    /// all of it.
    pub fn hold_stock(&mut self, solid: &Solid) {
        self.enter(STOCK, solid, 0.0, HeldRole::Stock);
    }

    fn enter(&mut self, name: &str, solid: &Solid, allowance: f64, role: HeldRole) {
        let mesh = solid.triangles(self.tolerance);
        self.held.push(HeldBody { name: name.to_owned(), mesh, allowance, role });
    }

    /// Returns the pairs that are not compared.
    pub fn left_out(&self) -> &[BodyMeeting] {
        &self.left_out
    }

    /// Returns the accuracy of round bodies \[mm\].
    pub(crate) fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Returns the number of pairs that are compared.
    pub fn pairs(&self) -> usize {
        self.pairs.len()
    }

    /// Enters a pair, or leaves it out.
    fn add(
        &mut self,
        machine: &Machine,
        pair: [usize; 2],
        tolerance: f64,
    ) -> Result<(), VerifyError> {
        let [Some(first), Some(second)] = pair.map(|k| self.all.get(k)) else { return Ok(()) };
        if first.link == second.link {
            return Ok(());
        }
        let bodies = [first, second].map(|body| body.name.clone());
        let may_touch = |of: &str, other: &str| {
            machine
                .bodies
                .iter()
                .any(|body| body.name == of && body.touches.iter().any(|t| t == other))
        };
        if may_touch(&bodies[0], &bodies[1]) || may_touch(&bodies[1], &bodies[0]) {
            self.left_out.push(BodyMeeting { bodies, why: "the machine file lets them touch" });
            return Ok(());
        }
        let compared = BodyPair::new(machine, [first, second]);
        if !compared.touches(&machine.home(), tolerance) {
            self.pairs.push(pair);
            return Ok(());
        }
        // A slide on its ways touches them wherever it is.
        if positions(machine, &compared).iter().all(|q| compared.touches(q, tolerance)) {
            self.left_out.push(BodyMeeting { bodies, why: "they touch wherever the axes are" });
            return Ok(());
        }
        let what = format!(
            "bodies {:?} and {:?} of the machine run into each other with all axes at home; correct one of them, or write \
             touches = [{:?}] in the table of the other if they may",
            bodies[0], bodies[1], bodies[1]
        );
        Err(VerifyError::Bodies { what })
    }
}

/// Returns positions all over the travel of the axes between two bodies, the others at home.
fn positions(machine: &Machine, pair: &BodyPair<'_>) -> Vec<AxisVector> {
    let mut all = vec![machine.home()];
    for index in pair.axes() {
        let Some(axis) = machine.axes.get(index) else { continue };
        let ends = axis.limits.ends();
        // An axis that turns without end is tried over one turn.
        let ends = if ends.iter().all(|end| end.is_finite()) { ends } else { [-PI, PI] };
        let at = |share: f64| ends[0] + (ends[1] - ends[0]) * share;
        all = all
            .iter()
            .flat_map(|q| {
                SHARES.iter().map(move |share| {
                    let mut moved = *q;
                    if let Some(value) = moved.get_mut(index) {
                        *value = at(*share);
                    }
                    moved
                })
            })
            .collect();
    }
    all
}

fn linked(
    machine: &Machine,
    body: &MachineBody,
    tolerance: f64,
) -> Result<LinkedBody, VerifyError> {
    let refuse = |what: &str| VerifyError::Bodies {
        what: format!("body {:?} of the machine {what}", body.name),
    };
    let link =
        machine.link_of(&body.link).ok_or_else(|| refuse("moves with no link of the chain"))?;
    let (mesh, allowance) = match &body.shape {
        BodyShape::Box { min, max } => {
            (Solid::Box { low: *min, high: *max }.triangles(tolerance), 0.0)
        }
        BodyShape::Cylinder { base, axis, radius, height } => {
            let axis = UnitVector3::try_new(Vector3::from(*axis), 0.0);
            let axis = axis.ok_or_else(|| refuse("has an axis of no length"))?;
            (revolved(base, &axis, &[[*radius, 0.0], [*radius, *height]], tolerance), 0.0)
        }
        BodyShape::Mesh { mesh, place, allowance } => {
            let solid = Solid::Mesh(Mesh::clone(mesh));
            let closed = Fixture::new(&solid, tolerance);
            closed.map_err(|error| refuse(&format!("cannot be used: {error}")))?;
            (placed(mesh, place), *allowance)
        }
        BodyShape::File { .. } => return Err(refuse("is in a file that was not read")),
    };
    LinkedBody::new(body.name.clone(), link, mesh, allowance).ok_or_else(|| refuse("has no volume"))
}
