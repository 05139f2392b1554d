//! `trunnion.drop_cutter` and meshes.

use crate::arrays::{Numbers, array, positive, whole};
use crate::cutter::Cutter;
use crate::errors::{WrongArgument, failure, input};
use crate::part::{self, Face, mesh_arrays};
use crate::progress::{StageWatch, in_slices};
use crate::scalar::scalar;
use numpy::{PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use std::path::PathBuf;
use trunnion::drop_cutter::{CuttingEnd, DropContact, DropIndex};
use trunnion::nalgebra::Point3;
use trunnion::surface::SurfaceError;
use trunnion::types::{Interval, Mesh};
use trunnion_cli::calls;

/// Finer triangulations that are tried until a face is met within the chord tolerance.
const REFINED: u32 = 6;

/// Triangles with a bound on their distance from the shape that they stand for.
struct BoundedMesh {
    mesh: Mesh,
    /// `None` if there is no bound \[mm\].
    deviation: Option<f64>,
}

/// Lowers a cutter on triangles, given as vertices and corners, or on faces.
#[pyfunction]
#[pyo3(signature = (shape, cutter, points, chord, bounds, progress=None))]
pub(crate) fn drop_cutter<'py>(
    shape: &Bound<'py, PyAny>,
    cutter: &Cutter,
    points: &Bound<'py, PyAny>,
    chord: f64,
    #[pyo3(from_py_with = scalar)] bounds: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = shape.py();
    let rows = Numbers::of("points", points)?;
    rows.shaped("points", &[&[0, 2], &[0, 3]])?;
    let places: Vec<[f64; 2]> = match rows.shape() {
        [_, 2] => rows.rows::<2>().to_vec(),
        _ => rows.rows::<3>().iter().map(|[x, y, _]| [*x, *y]).collect(),
    };
    let BoundedMesh { mesh, deviation } = mesh_of(shape, chord)?;
    let end = CuttingEnd::of(&cutter.0);
    let index = py.detach(|| DropIndex::new(&mesh)).map_err(|error| input(py, error))?;
    let watch = StageWatch { stage: "lowering the cutter", callable: progress.as_ref() };
    let found = in_slices(py, watch, &places, |slice| index.lowered_at(&end, slice))?;
    let answer = PyDict::new(py);
    let tips = found.iter().map(|of| of.map_or(f64::NAN, |of| of.tip.z)).collect();
    let contact = |of: &Option<DropContact>| of.map_or([f64::NAN; 3], |of| of.point.coords.into());
    let contacts = found.iter().flat_map(contact).collect();
    let number =
        |of: &Option<DropContact>| of.and_then(|of| i64::try_from(of.triangle).ok()).unwrap_or(-1);
    answer.set_item("z", array(py, tips, &[places.len()])?)?;
    answer.set_item("contact", array(py, contacts, &[places.len(), 3])?)?;
    answer.set_item("triangle", whole(py, found.iter().map(number).collect()))?;
    answer.set_item("deviation", deviation)?;
    if bounds && let Some(deviation) = deviation {
        let of = |place: &[f64; 2]| {
            let found = index.tip_bounds(&end, *place, deviation);
            found.map_or([f64::NAN; 2], Interval::ends)
        };
        let watch = StageWatch { stage: "bounding the heights", callable: progress.as_ref() };
        let rows = in_slices(py, watch, &places, |slice| slice.par_iter().map(of).collect())?;
        answer.set_item("bounds", array(py, rows.into_flattened(), &[places.len(), 2])?)?;
    }
    Ok(answer)
}

/// Reads the triangles of an STL file, or of a STEP solid.
#[pyfunction]
#[pyo3(signature = (path, chord=None))]
pub(crate) fn read_mesh(
    py: Python<'_>,
    path: PathBuf,
    chord: Option<f64>,
) -> PyResult<(Bound<'_, PyAny>, Bound<'_, PyAny>)> {
    let mesh = py.detach(|| calls::mesh(&path, chord)).map_err(|error| failure(py, error))?;
    mesh_arrays(py, &mesh)
}

/// Returns the triangles of a pair of arrays, or of faces within `chord`.
fn mesh_of(shape: &Bound<'_, PyAny>, chord: f64) -> PyResult<BoundedMesh> {
    let py = shape.py();
    if let Ok(faces) = shape.extract::<Vec<Face>>() {
        let chord = positive(py, "chord", chord)?;
        let all: PyResult<Vec<BoundedMesh>> =
            faces.iter().map(|face| tessellated(py, face, chord)).collect();
        return Ok(joined(&all?));
    }
    let (vertices, triangles): (Bound<'_, PyAny>, Bound<'_, PyAny>) = shape.extract()?;
    let numbers = Numbers::of("vertices", &vertices)?;
    numbers.shaped("vertices", &[&[0, 3]])?;
    let vertices = numbers.rows::<3>().iter().map(|row| Point3::from(*row)).collect();
    Ok(BoundedMesh {
        mesh: Mesh { vertices, triangles: corners(&triangles)? },
        deviation: Some(0.0),
    })
}

/// Takes corners of triangles, whole numbers.
fn corners(value: &Bound<'_, PyAny>) -> PyResult<Vec<[u32; 3]>> {
    let py = value.py();
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("ascontiguousarray", (value,))?;
    let wrong = |index: &[usize], value: String, defect: &str| {
        WrongArgument { name: "triangles", index, value, defect, remedy: "" }.error(py)
    };
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    if !matches!(shape[..], [_, 3]) {
        return Err(wrong(&[], format!("shape {shape:?}"), "is not (n, 3)"));
    }
    if kind != "i" && kind != "u" {
        return Err(wrong(&[], format!("dtype of kind {kind}"), "is not whole numbers"));
    }
    let array = array.call_method1("astype", ("int64",))?;
    let array = array.cast::<PyArrayDyn<i64>>()?.readonly();
    let values = array.as_slice()?;
    let corner = |(at, value): (usize, &i64)| {
        u32::try_from(*value)
            .map_err(|_| wrong(&[at / 3, at % 3], value.to_string(), "is no index of a vertex"))
    };
    let all: PyResult<Vec<u32>> = values.iter().enumerate().map(corner).collect();
    Ok(all?.as_chunks().0.to_vec())
}

/// Divides a face into triangles until the bound on their distance is at most `chord`.
fn tessellated(py: Python<'_>, face: &Face, chord: f64) -> PyResult<BoundedMesh> {
    let face = face.0.face();
    let divided = |asked: f64| {
        // A fine chord takes a while each time.
        py.check_signals()?;
        let made = py.detach(|| {
            let made = face.tessellate(asked)?;
            let deviation = made.deviation_bound(&face.surface);
            Ok(BoundedMesh { mesh: made.mesh, deviation })
        });
        made.map_err(|error: SurfaceError| input(py, error))
    };
    let mut asked = chord;
    for _ in 0..REFINED {
        let made = divided(asked)?;
        match made.deviation {
            // Distances go with the square of the cells, so with the chord that was asked for.
            Some(bound) if bound > chord => asked *= 0.9 * chord / bound,
            _ => return Ok(made),
        }
    }
    // The largest number of cells is reached: the bound is stated as it is.
    divided(asked)
}

/// Joins meshes; the deviation is that of the worst.
fn joined(all: &[BoundedMesh]) -> BoundedMesh {
    let worst =
        |worst: Option<f64>, one: &BoundedMesh| worst.zip(one.deviation).map(|(a, b)| a.max(b));
    let deviation = all.iter().fold(Some(0.0), worst);
    BoundedMesh { mesh: part::joined(all.iter().map(|one| &one.mesh)), deviation }
}
