//! The geometry of a face: any kind of surface behind one type.

use super::analytic::{
    ConeSurface, CylinderSurface, ElementarySurface, PlaneSurface, SphereSurface, TorusSurface,
};
use super::jet::{DerivativeTable, SurfaceJet, SurfaceJet1, SurfaceJet2};
use super::nurbs::NurbsSurface;
use super::swept::{ExtrusionSurface, RevolutionSurface};
use crate::types::Interval;
use nalgebra::{Point3, Rotation3};

/// A surface over a rectangle of parameters u, v, each possibly endless or periodic.
#[derive(Debug, Clone, PartialEq)]
pub enum Surface {
    /// B-spline, Bezier or rational tensor surface.
    Nurbs(NurbsSurface),
    /// Plane.
    Plane(PlaneSurface),
    /// Cylinder of revolution.
    Cylinder(CylinderSurface),
    /// Cone of revolution, one nappe.
    Cone(ConeSurface),
    /// Sphere.
    Sphere(SphereSurface),
    /// Torus.
    Torus(TorusSurface),
    /// A curve moved along a straight line.
    Extrusion(ExtrusionSurface),
    /// A curve turned about an axis.
    Revolution(RevolutionSurface),
}

impl Surface {
    /// Returns the elementary kinds, whose closest point is known in closed form.
    pub(super) fn elementary(&self) -> Option<&dyn ElementarySurface> {
        match self {
            Self::Plane(surface) => Some(surface),
            Self::Cylinder(surface) => Some(surface),
            Self::Cone(surface) => Some(surface),
            Self::Sphere(surface) => Some(surface),
            Self::Torus(surface) => Some(surface),
            Self::Nurbs(_) | Self::Extrusion(_) | Self::Revolution(_) => None,
        }
    }

    /// Returns the ranges of u and v; infinite where the surface has no end.
    pub fn domain(&self) -> [Interval; 2] {
        match self {
            Self::Nurbs(surface) => surface.domain(),
            Self::Extrusion(surface) => surface.domain(),
            Self::Revolution(surface) => surface.domain(),
            _ => self.elementary().map_or([Interval::point(0.0); 2], ElementarySurface::domain),
        }
    }

    /// Returns the periods by u and v; `None` where the surface does not close smoothly on itself.
    pub fn periods(&self) -> [Option<f64>; 2] {
        match self {
            Self::Nurbs(surface) => surface.periods(),
            Self::Extrusion(surface) => surface.periods(),
            Self::Revolution(surface) => surface.periods(),
            _ => self.elementary().map_or([None; 2], ElementarySurface::periods),
        }
    }

    /// Returns the parameters beyond which there is nothing, by u and v; infinite where the surface
    /// goes on. A rim of a spline surface that is a point has no continuation: it would turn over
    /// there.
    pub(crate) fn ends(&self) -> [Interval; 2] {
        match self {
            Self::Nurbs(surface) => surface.ends(),
            _ => [Interval::UNBOUNDED; 2],
        }
    }

    /// Returns `true` if the normal turns evenly everywhere: no parameter is an angle about a point
    /// of the surface, and no rim is a point.
    pub fn is_regular(&self) -> bool {
        match self {
            Self::Nurbs(surface) => surface.ends() == [Interval::UNBOUNDED; 2],
            Self::Extrusion(_) => true,
            _ => false,
        }
    }

    /// Returns the name of the kind, for tables and messages.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Nurbs(surface) if surface.is_rational() => "NURBS",
            Self::Nurbs(_) => "B-spline",
            Self::Plane(_) => "plane",
            Self::Cylinder(_) => "cylinder",
            Self::Cone(_) => "cone",
            Self::Sphere(_) => "sphere",
            Self::Torus(_) => "torus",
            Self::Extrusion(_) => "extrusion",
            Self::Revolution(_) => "revolution",
        }
    }

    /// Returns the surface turned about the origin of space, with the same parameters.
    #[must_use]
    pub fn turned(&self, rotation: &Rotation3<f64>) -> Self {
        match self {
            Self::Nurbs(surface) => Self::Nurbs(surface.turned(rotation)),
            Self::Plane(PlaneSurface { frame }) => {
                Self::Plane(PlaneSurface { frame: frame.turned(rotation) })
            }
            Self::Cylinder(surface) => Self::Cylinder(CylinderSurface {
                frame: surface.frame.turned(rotation),
                ..*surface
            }),
            Self::Cone(surface) => {
                Self::Cone(ConeSurface { frame: surface.frame.turned(rotation), ..*surface })
            }
            Self::Sphere(surface) => {
                Self::Sphere(SphereSurface { frame: surface.frame.turned(rotation), ..*surface })
            }
            Self::Torus(surface) => {
                Self::Torus(TorusSurface { frame: surface.frame.turned(rotation), ..*surface })
            }
            Self::Extrusion(surface) => Self::Extrusion(surface.turned(rotation)),
            Self::Revolution(surface) => Self::Revolution(surface.turned(rotation)),
        }
    }

    #[inline]
    pub(super) fn table<const ORDER: usize>(&self, u: f64, v: f64) -> DerivativeTable {
        match self {
            Self::Nurbs(surface) => surface.table::<ORDER>(u, v),
            Self::Plane(surface) => surface.table::<ORDER>(u, v),
            Self::Cylinder(surface) => surface.table::<ORDER>(u, v),
            Self::Cone(surface) => surface.table::<ORDER>(u, v),
            Self::Sphere(surface) => surface.table::<ORDER>(u, v),
            Self::Torus(surface) => surface.table::<ORDER>(u, v),
            Self::Extrusion(surface) => surface.table::<ORDER>(u, v),
            Self::Revolution(surface) => surface.table::<ORDER>(u, v),
        }
    }

    /// Returns the point at `(u, v)`.
    ///
    /// Outside the domain, by a parameter that is not periodic, spline surfaces are continued with
    /// the point and first two derivatives of the nearest border point; so for all derivatives.
    #[inline]
    pub fn point(&self, u: f64, v: f64) -> Point3<f64> {
        match self {
            Self::Nurbs(surface) => surface.point(u, v),
            _ => Point3::from(self.table::<0>(u, v)[0][0]),
        }
    }

    /// Returns the point and first derivatives.
    #[inline]
    pub fn jet1(&self, u: f64, v: f64) -> SurfaceJet1 {
        match self {
            Self::Nurbs(surface) => {
                let SurfaceJet2 { s, su, sv, .. } = surface.jet2(u, v);
                SurfaceJet1 { s, su, sv }
            }
            _ => SurfaceJet1::from_table(&self.table::<1>(u, v)),
        }
    }

    /// Returns the point and derivatives to order 2.
    #[inline]
    pub fn jet2(&self, u: f64, v: f64) -> SurfaceJet2 {
        match self {
            Self::Nurbs(surface) => surface.jet2(u, v),
            _ => SurfaceJet2::from_table(&self.table::<2>(u, v)),
        }
    }

    /// Returns the point and derivatives to order 3.
    #[inline]
    pub fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        SurfaceJet::from_table(&self.table::<3>(u, v))
    }
}
