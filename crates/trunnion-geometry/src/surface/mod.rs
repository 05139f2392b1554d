//! Surfaces and faces: points, derivatives to order 3, normals, curvature and its bounds, closest
//! points, trim loops.
//!
//! A [`Surface`] is geometry over a rectangle of parameters: NURBS, analytic or swept. A [`Face`]
//! is a surface with trim loops and a side. A [`FaceIndex`] answers closest-point queries on a
//! face. Lengths in mm.
//!
//! # Example
//!
//! ```
//! use nalgebra::{Point3, Vector3};
//! use trunnion_geometry::surface::{Face, FaceIndex, SphereSurface, Surface, SurfaceFrame};
//!
//! // A sphere of radius 10 mm about the origin; (u, v) = (longitude, latitude).
//! let frame = SurfaceFrame::new(Point3::origin(), Vector3::z(), Vector3::x())?;
//! let sphere = Surface::Sphere(SphereSurface::new(frame, 10.0)?);
//! let face = Face::new(1, sphere, vec![])?;
//! assert!((face.point(0.0, 0.0) - Point3::new(10.0, 0.0, 0.0)).norm() < 1e-12);
//!
//! // The closest point to (0, 0, 13) is the pole, 3 mm away.
//! let index = FaceIndex::new(face)?;
//! let foot = index.closest(&Point3::new(0.0, 0.0, 13.0))?;
//! assert!((foot.distance - 3.0).abs() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod analytic;
mod beyond;
mod bounds;
mod creases;
mod crossing;
mod curvature_source;
mod curvatures;
mod curve;
mod error;
mod face;
mod geometry;
mod grid;
mod hull;
mod index;
mod jet;
mod mesh;
mod mesh_deviation;
mod newton;
mod nurbs;
mod over_box;
mod parameter_box;
mod patches;
mod proximity;
mod swept;
mod trim;
mod trimmed_grid;

pub use analytic::{
    ConeSurface, CylinderSurface, PlaneSurface, SphereSurface, SurfaceFrame, TorusSurface,
};
pub use curve::{CurveJet, NurbsCurve, SpaceCurve};
pub use error::{ClosestError, SurfaceError, SurfaceErrors};
pub use face::Face;
pub use geometry::Surface;
pub use grid::FaceSample;
pub use index::{FaceIndex, FootPoint};
pub use jet::{PrincipalCurvatures, SurfaceJet, SurfaceJet1, SurfaceJet2};
pub use mesh::FaceMesh;
pub use nurbs::{BezierPatch, NurbsSurface};
pub use proximity::{SolidDistance, SolidProximity};
pub use swept::{ExtrusionSurface, RevolutionSurface};
pub use trim::{TrimCurve, TrimLoop};
