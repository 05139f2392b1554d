//! Meshes on which no cutter can be lowered.

/// Reason why triangles cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DropError {
    /// A corner names a vertex that does not exist.
    #[error(
        "triangle {triangle} has corner {corner}, and the mesh has {vertices} vertices, counted from 0"
    )]
    Corner {
        /// Index of the triangle.
        triangle: usize,
        /// Index that it names.
        corner: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is not a finite number")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
    },
    /// More triangles than an index counts.
    #[error("the mesh has {triangles} triangles, more than {most}; divide it")]
    TooMany {
        /// Number of triangles.
        triangles: usize,
        /// Largest number.
        most: usize,
    },
}
