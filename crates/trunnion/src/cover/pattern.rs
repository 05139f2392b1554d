//! Feed direction, order and placement of passes.

/// Feed direction of the passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FeedDirection {
    /// Iso-parametric along u: passes lie at constant v.
    U,
    /// Iso-parametric along v: passes lie at constant u.
    V,
    /// Along the direction of least curvature towards the cutter. Across it the face bends most like the
    /// cutter, so the strip is wide.
    Curvature,
    /// The cheapest by estimate: along u, along v, or along bent passes that keep the strips wide.
    Adaptive,
}

/// Order of the feed directions of neighbouring passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CutPattern {
    /// To and fro. The return pass has its strip on the other side of the feed.
    ZigZag,
    /// All passes run towards growing parameters.
    OneWay,
}

/// Placement of the tool at a station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlacementMethod {
    /// The widest strip. A pass without one is placed at [`CoverOptions::lean`](super::CoverOptions::lean).
    Widest,
    /// At the fixed inclination everywhere.
    Inclined,
}

/// Use of passes for prismatic shapes: the flank on walls, the underside on floors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PrismaticUse {
    /// Never: all faces are covered by strips.
    Never,
    /// On planes, cylinders, cones and extrusions, wherever such passes finish the face.
    WallsAndFloors,
    /// The flank alone: a face that it cannot cut is an error.
    Flank,
}
