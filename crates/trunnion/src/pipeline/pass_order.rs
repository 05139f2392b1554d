//! Order of the faces within an operation: each next to the one before, where that shortens the links.

use super::estimate::TravelEstimate;
use crate::machine::Kinematics;
use crate::types::{Pass, ToolPose};

/// Most groups of passes that are put in order: the estimates grow with the square of their number.
const MOST_GROUPS: usize = 400;

/// Puts the faces in an order with short links between them; the passes of a face stay as they are.
///
/// After each face follows the one that begins nearest to its end in time of the machine. If the links are no shorter
/// as a whole, the order stays.
pub(super) fn shorten_links(kinematics: &Kinematics, passes: Vec<Pass>) -> Vec<Pass> {
    let Some(estimate) = TravelEstimate::new(kinematics) else { return passes };
    in_order(passes, &|from, to| estimate.seconds(&[*from, *to]))
}

/// Ends of the passes of one face.
#[derive(Clone, Copy)]
struct FaceEnds {
    first: ToolPose,
    last: ToolPose,
}

fn in_order(passes: Vec<Pass>, seconds: &dyn Fn(&ToolPose, &ToolPose) -> f64) -> Vec<Pass> {
    let groups: Vec<&[Pass]> = passes.chunk_by(|a, b| a.face == b.face).collect();
    let ends: Option<Vec<FaceEnds>> = groups.iter().map(|group| ends(group)).collect();
    let Some(ends) = ends.filter(|ends| (3..=MOST_GROUPS).contains(&ends.len())) else {
        return passes;
    };
    let link = |from: usize, to: usize| seconds(&ends[from].last, &ends[to].first);
    let mut order = vec![0];
    let mut left: Vec<usize> = (1..ends.len()).collect();
    while let Some(&from) = order.last().filter(|_| !left.is_empty()) {
        // Of equal ones the first.
        let nearest =
            (0..left.len()).min_by(|a, b| link(from, left[*a]).total_cmp(&link(from, left[*b])));
        order.push(left.remove(nearest.unwrap_or(0)));
    }
    let whole = |order: &[usize]| order.windows(2).map(|pair| link(pair[0], pair[1])).sum::<f64>();
    let given: Vec<usize> = (0..ends.len()).collect();
    if whole(&order) >= whole(&given) {
        return passes;
    }
    order.into_iter().flat_map(|index| groups[index].iter().cloned()).collect()
}

/// Returns the first and the last pose of some passes.
fn ends(group: &[Pass]) -> Option<FaceEnds> {
    let first = group.first()?.stations.first()?.pose;
    Some(FaceEnds { first, last: group.last()?.stations.last()?.pose })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{Station, Uv};
    use nalgebra::{Point3, Vector3};

    fn pass(face: usize, [from, to]: [f64; 2]) -> Pass {
        let at = |x: f64| {
            let tip = Point3::new(x, 0.0, 0.0);
            Station { pose: ToolPose { tip, axis: Vector3::z_axis() }, contact: tip }
        };
        let stations = vec![at(from), at(to)];
        Pass { face, stations, widths: vec![1.0; 2], track: vec![Uv::new(0.0, 0.0); 2] }
    }

    fn distance(from: &ToolPose, to: &ToolPose) -> f64 {
        (to.tip - from.tip).norm()
    }

    fn faces(passes: Vec<Pass>) -> Vec<usize> {
        in_order(passes, &distance).iter().map(|pass| pass.face).collect()
    }

    #[test]
    fn each_face_follows_the_one_that_ends_near_it() {
        // Four walls in a row, listed against their direction of cutting.
        let walls = vec![
            pass(1, [0.0, 10.0]),
            pass(4, [33.0, 43.0]),
            pass(3, [22.0, 32.0]),
            pass(2, [11.0, 21.0]),
        ];
        assert_eq!(faces(walls), [1, 2, 3, 4]);
        // The passes of a face stay together and in their order.
        let strips = vec![
            pass(1, [0.0, 10.0]),
            pass(3, [50.0, 40.0]),
            pass(3, [40.0, 50.0]),
            pass(2, [12.0, 30.0]),
        ];
        let ordered = in_order(strips, &distance);
        let starts: Vec<f64> = ordered.iter().map(|pass| pass.stations[0].pose.tip.x).collect();
        assert_eq!(starts, [0.0, 12.0, 50.0, 40.0]);
    }

    /// The nearest next is not the best as a whole here: far away is the one that was passed by.
    #[test]
    fn an_order_that_is_no_shorter_is_not_taken() {
        let given = vec![
            pass(1, [0.0, 0.0]),
            pass(2, [-2.0, -2.0]),
            pass(3, [1.0, 1.0]),
            pass(4, [5.0, 100.0]),
        ];
        let nearest = 1.0 + 3.0 + 7.0;
        let listed = 2.0 + 3.0 + 4.0;
        assert!(nearest > listed);
        assert_eq!(faces(given), [1, 2, 3, 4]);
    }
}
