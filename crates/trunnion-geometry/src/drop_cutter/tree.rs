//! Boxes over triangles, as a tree.

use nalgebra::{Point3, Vector2};

/// Most triangles of a leaf.
const LEAF: usize = 4;

/// Extent in x and y, and the top.
#[derive(Debug, Clone, Copy)]
pub(super) struct FlatBox {
    low: Vector2<f64>,
    high: Vector2<f64>,
    pub(super) top: f64,
}

impl FlatBox {
    fn of(corners: &[Point3<f64>; 3]) -> Self {
        let [a, b, c] = corners.each_ref().map(Point3::xy);
        Self {
            low: a.inf(&b).inf(&c).coords,
            high: a.sup(&b).sup(&c).coords,
            top: corners[0].z.max(corners[1].z).max(corners[2].z),
        }
    }

    fn with(&self, other: &Self) -> Self {
        Self {
            low: self.low.inf(&other.low),
            high: self.high.sup(&other.high),
            top: self.top.max(other.top),
        }
    }

    /// Returns the distance from a place, seen from above.
    pub(super) fn distance(&self, place: &Vector2<f64>) -> f64 {
        let nearest = place.sup(&self.low).inf(&self.high);
        (place - nearest).norm()
    }
}

/// Node: the triangles from `first`, or two nodes.
#[derive(Debug, Clone, Copy)]
pub(super) struct DropNode {
    pub(super) bounds: FlatBox,
    /// First triangle of a leaf; of others, the second child: the first follows at once.
    pub(super) first: u32,
    /// Triangles of a leaf; 0 of others.
    pub(super) count: u32,
}

/// Builds the tree, and puts the triangles in its order.
pub(super) fn build(triangles: &mut [IndexedTriangle]) -> Vec<DropNode> {
    let mut nodes = Vec::with_capacity(triangles.len());
    if !triangles.is_empty() {
        divide(triangles, 0, &mut nodes);
    }
    nodes
}

/// Triangle with its number in the mesh.
#[derive(Debug, Clone, Copy)]
pub(super) struct IndexedTriangle {
    pub(super) corners: [Point3<f64>; 3],
    pub(super) number: u32,
    pub(super) bounds: FlatBox,
}

impl IndexedTriangle {
    pub(super) fn new(corners: [Point3<f64>; 3], number: u32) -> Self {
        Self { corners, number, bounds: FlatBox::of(&corners) }
    }

    fn middle(&self, axis: usize) -> f64 {
        self.bounds.low[axis] + self.bounds.high[axis]
    }
}

fn divide(triangles: &mut [IndexedTriangle], first: usize, nodes: &mut Vec<DropNode>) {
    let mut boxes = triangles.iter().map(|of| of.bounds);
    let Some(start) = boxes.next() else { return };
    let bounds = boxes.fold(start, |all, own| all.with(&own));
    let narrow = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    let at = nodes.len();
    nodes.push(DropNode { bounds, first: narrow(first), count: narrow(triangles.len()) });
    if triangles.len() <= LEAF {
        return;
    }
    // Halves of equal number across the longer side.
    let size = bounds.high - bounds.low;
    let axis = usize::from(size.y > size.x);
    let half = triangles.len() / 2;
    triangles.select_nth_unstable_by(half, |a, b| a.middle(axis).total_cmp(&b.middle(axis)));
    let (low, high) = triangles.split_at_mut(half);
    divide(low, first, nodes);
    let second = narrow(nodes.len());
    if let Some(node) = nodes.get_mut(at) {
        (node.first, node.count) = (second, 0);
    }
    divide(high, first + half, nodes);
}
