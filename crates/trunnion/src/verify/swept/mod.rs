//! Kernel of the swept volume: the tool as convex bodies in motion.
//!
//! [`tool`] cuts a tool into convex bodies, [`quadratic`] its motion into pieces that are quadratic in time, [`distance`],
//! [`relative`] and [`rays`] measure points, planes and rays against a body on a piece. [`bvh`] and [`mesh`] find what is near, [`triangles`] how far meshes
//! are apart; [`revolved`] makes meshes of round solids.

pub(crate) mod bvh;
pub(crate) mod crossing;
pub(crate) mod distance;
pub(crate) mod mesh;
pub(crate) mod quadratic;
pub(crate) mod rays;
pub(crate) mod relative;
pub(crate) mod revolved;
pub(crate) mod tool;
pub(crate) mod triangles;
