//! `trunnion.position` and `trunnion.cover`.

use crate::arrays::{array, positive};
use crate::cutter::Cutter;
use crate::errors::{WrongArgument, input, input_with};
use crate::part::Face;
use crate::progress::watched;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use trunnion::cover::{
    self as covering, CoverOptions, CoverRequest, CutPattern, FeedDirection, FinishTolerance,
};
use trunnion::nalgebra::Vector3;
use trunnion::positioning::{
    ContactSide, LocationRequest, PlacementMethod, PositioningError, StripSide, ToleranceBand,
    ToolInclination, place, trace,
};
use trunnion::surface::FaceIndex;
use trunnion::types::{Interval, Pass};

/// Numbers and names of a request for one cutter location.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct PositionOptions {
    at: [f64; 2],
    feed: [f64; 2],
    tolerance: f64,
    strip: String,
    side: String,
    offset_range: [f64; 2],
    method: String,
    lead: f64,
}

/// Places one cutter location.
#[pyfunction]
pub(crate) fn position<'py>(
    py: Python<'py>,
    face: &Face,
    cutter: &Cutter,
    options: PositionOptions,
) -> PyResult<Bound<'py, PyDict>> {
    let upper = positive(py, "tolerance", options.tolerance)?;
    let method = method(py, &options)?;
    let request = LocationRequest {
        strip: if options.strip == "left" { StripSide::Left } else { StripSide::Right },
        side: match options.side.as_str() {
            "behind" => ContactSide::Behind,
            "either" => ContactSide::Either,
            _ => ContactSide::Ahead,
        },
        offset_range: Interval::new(options.offset_range[0], options.offset_range[1]),
        ..LocationRequest::new(
            &face.0,
            &cutter.0,
            ToleranceBand { lower: 0.0, upper },
            options.at.into(),
            options.feed,
        )
    };
    let refused =
        |error: PositioningError| input_with(py, &error, &error.remedy().unwrap_or_default());
    let found = py.detach(|| place(&request, &method)).map_err(refused)?;
    let answer = PyDict::new(py);
    let point = |point: [f64; 3]| array(py, point.to_vec(), &[3]);
    for (name, value) in [
        ("strip_width", found.strip_width),
        ("chord_width", found.chord_width),
        ("offset", found.offset),
        ("offset_direction", found.offset_direction),
        ("rotation", found.rotation),
        ("front_max", found.front_max),
        ("front_max_bound", found.front_max_bound),
        ("front_min", found.front_min),
        ("rear_min", found.rear_min),
        ("rear_min_bound", found.rear_min_bound),
    ] {
        answer.set_item(name, value)?;
    }
    answer.set_item("method", options.method)?;
    answer.set_item("queries", found.queries)?;
    answer.set_item("tip", point(found.pose.tip.coords.into())?)?;
    answer.set_item("axis", point(found.pose.axis.into_inner().into())?)?;
    answer.set_item("center", point(found.center.coords.into())?)?;
    answer.set_item("contact", point(found.contact.coords.into())?)?;
    let angles = found.contact_angles.clone();
    let count = angles.len();
    answer.set_item("contact_angles", array(py, angles, &[count])?)?;
    let active: Vec<String> = found.active.iter().map(|active| format!("{active:?}")).collect();
    answer.set_item("active", active)?;
    // The error curve, for pictures.
    let placed = method.cutter(&cutter.0).map_err(refused)?;
    let request = LocationRequest { cutter: &placed, ..request };
    if let Ok(trace) = trace(&request, &found, "error") {
        let samples: Vec<f64> = trace
            .points
            .iter()
            .flat_map(|point| [point.angle, point.across, point.error])
            .collect();
        let count = trace.points.len();
        answer.set_item("error_curve", array(py, samples, &[count, 3])?)?;
    }
    Ok(answer)
}

fn method(py: Python<'_>, options: &PositionOptions) -> PyResult<PlacementMethod> {
    let lead = options.lead;
    Ok(match options.method.as_str() {
        "end-point" => PlacementMethod::EndPoint,
        "mpm" => PlacementMethod::MultiPoint,
        "hermite" => PlacementMethod::HermiteChebyshev,
        "lead-swivel" => PlacementMethod::LeadSwivel { swivel: lead },
        "curvature" => PlacementMethod::CurvatureMatched,
        "sturz" => PlacementMethod::Sturz { lead },
        "three-axis" => PlacementMethod::FixedAxis { axis: Vector3::z_axis() },
        "ball" => PlacementMethod::Ball { lead },
        other => {
            let known = "end-point, mpm, hermite, lead-swivel, curvature, sturz, three-axis, ball";
            return Err(input(py, format!("method = {other:?} is not one of {known}")));
        }
    })
}

/// Names and numbers of a request for passes.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct CoverArguments {
    excess: f64,
    gouge: f64,
    along: String,
    pattern: String,
    method: String,
    lead: f64,
    tilt: f64,
}

/// Covers faces with passes.
#[pyfunction]
pub(crate) fn cover<'py>(
    py: Python<'py>,
    faces: Vec<Face>,
    cutter: &Cutter,
    arguments: CoverArguments,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let cutter = &cutter.0;
    let within = |name: &str, value: f64| {
        let value = positive(py, name, value)?;
        // Beyond its radius a cutter finishes everything and nothing.
        if value <= cutter.radius() {
            return Ok(value);
        }
        let defect = format!("is more than the radius of the cutter, {} mm", cutter.radius());
        let (value, defect) = (value.to_string(), defect.as_str());
        Err(WrongArgument { name, index: &[], value, defect, remedy: "" }.error(py))
    };
    let tolerance = FinishTolerance {
        excess: within("excess", arguments.excess)?,
        gouge: within("gouge", arguments.gouge)?,
    };
    let options = CoverOptions {
        feed_direction: match arguments.along.as_str() {
            "u" => FeedDirection::U,
            "v" => FeedDirection::V,
            "curvature" => FeedDirection::Curvature,
            _ => FeedDirection::Adaptive,
        },
        pattern: if arguments.pattern == "one-way" {
            CutPattern::OneWay
        } else {
            CutPattern::ZigZag
        },
        method: if arguments.method == "inclined" {
            covering::PlacementMethod::Inclined
        } else {
            covering::PlacementMethod::Widest
        },
        lean: ToolInclination::of(arguments.lead, arguments.tilt),
        ..CoverOptions::finishing(cutter, tolerance)
    };
    let faces: Vec<FaceIndex> = faces.iter().map(|face| (*face.0).clone()).collect();
    let covered = watched(py, progress.as_ref(), |watch| {
        covering::cover(&CoverRequest::new(&faces, cutter, &options), watch)
    })?
    .map_err(|error| input(py, error))?;
    let answer = PyDict::new(py);
    let passes: PyResult<Vec<Bound<'py, PyDict>>> =
        covered.passes.iter().map(|pass| pass_of(py, pass)).collect();
    answer.set_item("passes", PyList::new(py, passes?)?)?;
    answer.set_item("length", covered.report.length)?;
    answer.set_item("area", covered.report.area)?;
    answer.set_item("stations", covered.report.stations)?;
    answer.set_item("worst_gouge", covered.report.worst_gouge)?;
    let rest: PyResult<Vec<Bound<'py, PyDict>>> = covered
        .report
        .rest
        .iter()
        .map(|of| {
            let region = PyDict::new(py);
            region.set_item("face", of.face)?;
            region.set_item("area", of.area)?;
            region.set_item("depth", of.depth)?;
            Ok(region)
        })
        .collect();
    answer.set_item("unfinished", PyList::new(py, rest?)?)?;
    Ok(answer)
}

/// Returns tips, axes, contacts and strip widths of a pass.
pub(crate) fn pass_of<'py>(py: Python<'py>, pass: &Pass) -> PyResult<Bound<'py, PyDict>> {
    let count = pass.stations.len();
    let answer = PyDict::new(py);
    let rows = |row: &dyn Fn(&trunnion::types::Station) -> [f64; 3]| {
        array(py, pass.stations.iter().flat_map(row).collect(), &[count, 3])
    };
    answer.set_item("face", pass.face)?;
    answer.set_item("tip", rows(&|station| station.pose.tip.coords.into())?)?;
    answer.set_item("axis", rows(&|station| station.pose.axis.into_inner().into())?)?;
    answer.set_item("contact", rows(&|station| station.contact.coords.into())?)?;
    answer.set_item("width", array(py, pass.widths.clone(), &[pass.widths.len()])?)?;
    let track = pass.track.iter().flat_map(|at| [at.u, at.v]).collect();
    answer.set_item("track", array(py, track, &[pass.track.len(), 2])?)?;
    Ok(answer)
}
