//! Bounding volume hierarchy: finds the pieces and bodies that can touch a region.

use nalgebra::Point3;

/// Axis-parallel box.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoundingBox {
    pub(crate) low: Point3<f64>,
    pub(crate) high: Point3<f64>,
}

impl BoundingBox {
    /// Returns a box that contains nothing.
    pub(crate) fn empty() -> Self {
        Self { low: Point3::from([f64::INFINITY; 3]), high: Point3::from([f64::NEG_INFINITY; 3]) }
    }

    /// Returns a box that contains everything.
    pub(crate) fn everywhere() -> Self {
        Self { low: Point3::from([f64::NEG_INFINITY; 3]), high: Point3::from([f64::INFINITY; 3]) }
    }

    /// Returns the smallest box around both.
    pub(crate) fn join(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// Returns the box grown by `margin` on every side.
    pub(crate) fn grown(&self, margin: f64) -> Self {
        let margin = nalgebra::Vector3::repeat(margin);
        Self { low: self.low - margin, high: self.high + margin }
    }

    pub(crate) fn meets(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }

    fn middle(&self, k: usize) -> f64 {
        self.low[k] + self.high[k]
    }
}

/// Box with its content.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TreeItem {
    pub(crate) bounds: BoundingBox,
    pub(crate) content: ContentId,
}

/// Numbers of what a box contains, in ascending order of both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ContentId {
    /// Number of the piece of motion, triangle or other item.
    pub(crate) item: u32,
    /// Number of the body in motion; 0 for items without bodies.
    pub(crate) body: u32,
}

impl ContentId {
    /// Returns the numbers of an item without bodies.
    pub(crate) fn item(item: u32) -> Self {
        Self { item, body: 0 }
    }
}

/// Tree of bounding boxes.
#[derive(Debug)]
pub(crate) struct BoxTree {
    nodes: Vec<TreeNode>,
    items: Vec<TreeItem>,
}

/// Most items in a leaf.
const LEAF: usize = 8;

/// Children of a node.
#[derive(Debug)]
pub(crate) enum TreeChildren<'a> {
    Nodes([usize; 2]),
    Items(&'a [TreeItem]),
}

#[derive(Debug)]
struct TreeNode {
    bounds: BoundingBox,
    /// Items of a leaf, or the second child of a fork; the first child follows its parent directly.
    kind: NodeKind,
}

#[derive(Debug)]
enum NodeKind {
    Leaf { first: usize, count: usize },
    Fork { second: usize },
}

impl BoxTree {
    /// Builds the tree by splitting at the median along the longest side.
    pub(crate) fn new(mut items: Vec<TreeItem>) -> Self {
        let mut nodes = Vec::new();
        let count = items.len();
        if count > 0 {
            build(&mut nodes, &mut items, 0, count);
        }
        Self { nodes, items }
    }

    /// Tests if anything may be in a region.
    pub(crate) fn meets(&self, region: &BoundingBox) -> bool {
        self.nodes.first().is_some_and(|all| all.bounds.meets(region))
    }

    /// Returns the number of the root, if there is one.
    pub(crate) fn root(&self) -> Option<usize> {
        (!self.nodes.is_empty()).then_some(0)
    }

    /// Returns the box of a node.
    pub(crate) fn bounds(&self, node: usize) -> Option<&BoundingBox> {
        self.nodes.get(node).map(|node| &node.bounds)
    }

    /// Returns the children of a node.
    pub(crate) fn below(&self, node: usize) -> TreeChildren<'_> {
        match self.nodes.get(node).map(|node| &node.kind) {
            Some(NodeKind::Fork { second }) => TreeChildren::Nodes([node + 1, *second]),
            Some(NodeKind::Leaf { first, count }) => {
                TreeChildren::Items(self.items.get(*first..first + count).unwrap_or_default())
            }
            None => TreeChildren::Items(&[]),
        }
    }

    /// Collects the contents of all boxes that meet a region, each once and in ascending order.
    pub(crate) fn near(&self, region: &BoundingBox, found: &mut Vec<ContentId>) {
        found.clear();
        let mut open = vec![0];
        while let Some(at) = open.pop() {
            let Some(node) = self.nodes.get(at) else { continue };
            if !node.bounds.meets(region) {
                continue;
            }
            match node.kind {
                NodeKind::Fork { second } => open.extend([at + 1, second]),
                NodeKind::Leaf { first, count } => {
                    let items = self.items.iter().skip(first).take(count);
                    found.extend(
                        items.filter(|item| item.bounds.meets(region)).map(|item| item.content),
                    );
                }
            }
        }
        // A body has several boxes, so its numbers may be found more than once.
        found.sort_unstable();
        found.dedup();
    }
}

/// Appends the subtree of `items[first..first + count]`.
fn build(nodes: &mut Vec<TreeNode>, items: &mut [TreeItem], first: usize, count: usize) {
    let bounds = items.iter().fold(BoundingBox::empty(), |all, item| all.join(&item.bounds));
    let at = nodes.len();
    // Entered as a leaf before its children, so that the first child follows it directly; a fork replaces it below.
    nodes.push(TreeNode { bounds, kind: NodeKind::Leaf { first, count } });
    if count <= LEAF {
        return;
    }
    // Median split across the longest side; contents break ties, so that the tree depends on the items alone.
    let size = bounds.high - bounds.low;
    let half = count / 2;
    items.select_nth_unstable_by(half, |a, b| {
        let k = size.imax();
        let order = a.bounds.middle(k).total_cmp(&b.bounds.middle(k));
        order.then(a.content.cmp(&b.content))
    });
    let (left, right) = items.split_at_mut(half);
    build(nodes, left, first, half);
    let second = nodes.len();
    build(nodes, right, first + half, count - half);
    if let Some(node) = nodes.get_mut(at) {
        node.kind = NodeKind::Fork { second };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_what_a_loop_over_all_boxes_finds() {
        let cube = |x: f64, size: f64| BoundingBox {
            low: Point3::new(x, (7.0 * x).sin() * 9.0, (3.0 * x).cos() * 5.0),
            high: Point3::new(x + size, (7.0 * x).sin() * 9.0 + size, (3.0 * x).cos() * 5.0 + size),
        };
        let items: Vec<TreeItem> = (0..500)
            .map(|i| TreeItem {
                bounds: cube(f64::from(i) * 0.1, 1.5),
                content: ContentId { item: i / 2, body: 0 },
            })
            .collect();
        let tree = BoxTree::new(items.clone());
        let mut found = Vec::new();
        for i in 0..60 {
            let region = cube(f64::from(i), 3.0);
            tree.near(&region, &mut found);
            let mut all: Vec<_> =
                items.iter().filter(|i| i.bounds.meets(&region)).map(|i| i.content).collect();
            all.dedup();
            assert_eq!(found, all);
        }
    }
}
