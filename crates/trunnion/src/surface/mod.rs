//! Point, derivatives to order 3, normal, curvature and its bounds, closest point, trim loops;
//! NURBS and analytic surfaces.
