//! Rigid links of a machine: their motions, and the check of the bodies on them.

use super::checked::{Axis, Machine};
use super::error::MachineError;
use super::spec::{AxisKind, MachineSpec};
use crate::math;
use crate::types::{AXES, AxisVector};
use nalgebra::{Isometry3, Translation3};

/// Number of rigid links: the workpiece is on the first, the tool on the last.
pub const LINKS: usize = AXES + 1;

impl Machine {
    /// Returns the indices of the axes, as in an [`AxisVector`], from the workpiece to the tool: joint `k` is between the
    /// links `k` and `k + 1`.
    pub fn joints(&self) -> [usize; AXES] {
        let mut joints = [0; AXES];
        let names = self.chain.iter().filter_map(|word| self.index_of(word));
        for (joint, index) in joints.iter_mut().zip(names) {
            *joint = index;
        }
        joints
    }

    /// Returns the number of the link that a name of the chain stands for: `w`, `t`, the bed `b`, or what an axis moves.
    pub fn link_of(&self, name: &str) -> Option<usize> {
        link_of(&self.chain, name)
    }

    /// Returns the place of a link in the frame of another one nearer to the workpiece. At zero both are the machine frame.
    pub fn link_motion(&self, from: usize, to: usize, q: &AxisVector) -> Isometry3<f64> {
        let joints = self.joints();
        let between = joints.iter().take(to).skip(from);
        let mut place = Isometry3::identity();
        for &index in between {
            if let (Some(axis), Some(value)) = (self.axes.get(index), q.get(index)) {
                place *= joint_motion(axis, *value);
            }
        }
        place
    }
}

/// Returns the motion of the links on the tool's side of a joint against those on the workpiece's side.
pub fn joint_motion(axis: &Axis, value: f64) -> Isometry3<f64> {
    let by = value * axis.sense;
    match axis.kind {
        AxisKind::Linear => Translation3::from(axis.dir.scale(by)).into(),
        AxisKind::Rotary => {
            let turn = math::quaternion_about(&axis.dir, by);
            Isometry3::rotation_wrt_point(turn, axis.point)
        }
    }
}

fn link_of(chain: &[String], name: &str) -> Option<usize> {
    let at = chain.iter().position(|word| word == name)?;
    let bed = chain.iter().position(|word| word == "b")?;
    // Links in order: the workpiece side ends with the bed, which takes no joint of its own.
    Some(match at.cmp(&bed) {
        // "w" is the first link, and so is what its neighbour moves.
        std::cmp::Ordering::Less => at.saturating_sub(1),
        std::cmp::Ordering::Equal => bed - 1,
        // "t" is what its neighbour moves.
        std::cmp::Ordering::Greater => (at - 1).min(chain.len().saturating_sub(3)),
    })
}

/// Checks the bodies of a machine.
pub(super) fn bodies(spec: &MachineSpec, faults: &mut Vec<MachineError>) {
    for (number, body) in spec.bodies.iter().enumerate() {
        let key = |what: &str| format!("body.{number}.{what}");
        let mut refuse = |key: String, what: String, remedy: String| {
            faults.push(MachineError::Body { key, what, remedy });
        };
        if spec.bodies.iter().take(number).any(|other| other.name == body.name) {
            let what = format!("two bodies are called {:?}", body.name);
            refuse(key("name"), what, "give each its own name".to_owned());
        }
        if link_of(&spec.chain, &body.link).is_none() {
            let what = format!(
                "body {:?} moves with {:?}, which is not in the chain",
                body.name, body.link
            );
            refuse(key("link"), what, format!("name one of {}", spec.chain.join(", ")));
        }
        for other in &body.touches {
            if !spec.bodies.iter().any(|body| body.name == *other) {
                let what = format!("body {:?} touches {other:?}, which is no body", body.name);
                refuse(key("touches"), what, "name another body of this file".to_owned());
            }
        }
        if let Some((entry, what)) = body.shape.fault() {
            refuse(
                key(entry),
                format!("body {:?}: {what}", body.name),
                "correct the numbers".to_owned(),
            );
        }
    }
}
