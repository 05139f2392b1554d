//! `trunnion.Part` and `trunnion.Face`.

use crate::arrays::{Numbers, array, positive};
use crate::errors::{WrongArgument, failure, input};
use crate::progress::{StageWatch, adapted, in_slices, watched};
use crate::scalar::scalar;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;
use trunnion::import::inspect;
use trunnion::nalgebra::Point3;
use trunnion::surface::{Face as LibraryFace, FaceIndex, NurbsSurface, Surface};
use trunnion::types::{Interval, Mesh};
use trunnion_cli::calls;

/// Faces of a part; or the triangles of an STL file, which have no faces.
#[pyclass(module = "trunnion", frozen)]
#[derive(Debug)]
pub(crate) struct Part {
    pub(crate) faces: Vec<Py<Face>>,
    warnings: Vec<String>,
    /// Triangles of an STL file.
    triangles: Option<Mesh>,
}

/// Face with everything that searches on it need.
#[pyclass(module = "trunnion", frozen, from_py_object)]
#[derive(Debug, Clone)]
pub(crate) struct Face(pub(crate) Arc<FaceIndex>);

#[pymethods]
impl Part {
    /// Reads a part.
    ///
    /// Args:
    ///     path: surface JSON or STEP file, or its content as bytes; or an STL file, of which there are triangles alone.
    ///     progress: callable of (stage, done, total), or tqdm.
    ///
    /// Raises:
    ///     InputError: every fault of the file.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> square = b'{"degree": [1, 1], "knots": [[0, 0, 1, 1], [0, 0, 1, 1]], "points": [[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0]]]}'
    ///     >>> len(trunnion.Part.read(square))
    ///     1
    #[staticmethod]
    #[pyo3(signature = (path, *, progress=None))]
    fn read(path: &Bound<'_, PyAny>, progress: Option<Py<PyAny>>) -> PyResult<Self> {
        let py = path.py();
        let progress = adapted(py, progress)?;
        let read = if let Ok(bytes) = path.cast::<PyBytes>() {
            let (name, bytes) = (PathBuf::from("part"), bytes.as_bytes().to_vec());
            watched(py, progress.as_ref(), |watch| calls::part_of_bytes(&name, &bytes, watch))?
        } else {
            let path: PathBuf = path.extract().map_err(|_| no_part(path))?;
            if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("stl")) {
                let mesh = py.detach(|| calls::mesh(&path, None));
                let triangles = Some(mesh.map_err(|error| failure(py, error))?);
                return Ok(Self { faces: Vec::new(), warnings: Vec::new(), triangles });
            }
            watched(py, progress.as_ref(), |watch| calls::part(&path, watch))?
        };
        let part = read.map_err(|error| failure(py, error))?;
        let warnings = part.warnings.iter().map(ToString::to_string).collect();
        let made: PyResult<Vec<Py<Face>>> =
            part.faces.into_iter().map(|face| Py::new(py, Face::index(py, face)?)).collect();
        Ok(Self { faces: made?, warnings, triangles: None })
    }

    /// Makes a part of one B-spline face.
    ///
    /// Args:
    ///     points: control net, i along u, j along v, (nu, nv, 3) [mm].
    ///     degree: degrees by u and v; lowered where the net has too few points.
    ///     knots: full clamped knot vectors by u and v; else equal spans from 0 to 1.
    ///     weights: positive weights, (nu, nv).
    ///     flip: the cutter is on the side opposite to S_u x S_v.
    ///
    /// Raises:
    ///     InputError: the net is degenerate, or the knots do not fit.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> face = trunnion.Part.from_net([[[0, 0, 0], [0, 8, 0]], [[4, 0, 0], [4, 8, 0]]]).faces[0]
    ///     >>> face.point([0.5, 0.25]).tolist()
    ///     [2.0, 2.0, 0.0]
    #[staticmethod]
    #[pyo3(signature = (points, degree=[3, 3], knots=None, weights=None, *, flip=false))]
    fn from_net(
        points: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = scalar)] degree: [usize; 2],
        #[pyo3(from_py_with = scalar)] knots: Option<[Vec<f64>; 2]>,
        weights: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = scalar)] flip: bool,
    ) -> PyResult<Self> {
        let py = points.py();
        let net = Numbers::of("points", points)?;
        net.shaped("points", &[&[0, 0, 3]])?;
        let [rows, columns] = [net.shape()[0], net.shape()[1]];
        let [u, v] = degree;
        let degree = [u.min(rows.saturating_sub(1)), v.min(columns.saturating_sub(1))];
        if rows < 2 || columns < 2 {
            let value = format!("shape ({rows}, {columns}, 3)");
            let defect = "has less than two points in a direction";
            let wrong = WrongArgument { name: "points", index: &[], value, defect, remedy: "" };
            return Err(wrong.error(py));
        }
        let knots = match knots {
            Some(knots) => knots,
            None => [uniform(rows, degree[0]), uniform(columns, degree[1])],
        };
        let weights = weights.map(|weights| Numbers::of("weights", weights)).transpose()?;
        if let Some(weights) = &weights {
            weights.shaped("weights", &[&[rows, columns]])?;
        }
        let row = |row: &[[f64; 3]]| row.iter().map(|point| Point3::from(*point)).collect();
        let points = net.rows::<3>().chunks(columns).map(row).collect();
        let weights = weights.map(|of| of.slice().chunks(columns).map(<[f64]>::to_vec).collect());
        let surface = NurbsSurface::new(degree, knots, points, weights);
        let surface = Surface::Nurbs(surface.map_err(|faults| input(py, faults))?);
        let face = LibraryFace::new(1, surface, Vec::new()).map_err(|error| input(py, error))?;
        let face = Face::index(py, LibraryFace { flip, ..face })?;
        Ok(Self { faces: vec![Py::new(py, face)?], warnings: Vec::new(), triangles: None })
    }

    /// Faces of the part.
    #[getter]
    fn faces(&self, py: Python<'_>) -> Vec<Py<Face>> {
        self.faces.iter().map(|face| face.clone_ref(py)).collect()
    }

    /// Remarks about the file.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Returns vertices (v, 3) [mm] and corners (t, 3) of the triangles of an STL file, or of triangles within about
    /// `chord` [mm] of all faces.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> part = trunnion.Part.from_net([[[0, 0, 0], [0, 8, 0]], [[4, 0, 0], [4, 8, 0]]])
    ///     >>> vertices, triangles = part.mesh()
    ///     >>> vertices.max(axis=0).tolist()
    ///     [4.0, 8.0, 0.0]
    #[pyo3(signature = (chord=0.01))]
    fn mesh<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = scalar)] chord: f64,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        if let Some(triangles) = &self.triangles {
            return mesh_arrays(py, triangles);
        }
        let chord = positive(py, "chord", chord)?;
        let faces: Vec<&Face> = self.faces.iter().map(Py::get).collect();
        let made = py.detach(|| {
            let each = faces.iter().map(|face| face.0.face().tessellate(chord));
            each.map(|made| made.map(|made| made.mesh)).collect::<Result<Vec<Mesh>, _>>()
        });
        mesh_arrays(py, &joined(&made.map_err(|error| input(py, error))?))
    }

    /// Returns a drawing of the faces as SVG.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> part = trunnion.Part.from_net([[[0, 0, 0], [0, 8, 0]], [[4, 0, 0], [4, 8, 0]]])
    ///     >>> part.picture().startswith("<svg")
    ///     True
    fn picture(&self) -> String {
        let faces: Vec<LibraryFace> =
            self.faces.iter().map(|face| face.get().0.face().clone()).collect();
        inspect::picture(&faces)
    }

    fn _repr_html_(&self) -> String {
        match &self.triangles {
            Some(mesh) => format!("<p>{}</p>", triangles_words(mesh)),
            None => self.picture(),
        }
    }

    fn __len__(&self) -> usize {
        self.faces.len()
    }

    fn __repr__(&self) -> String {
        match &self.triangles {
            Some(mesh) => format!("Part({})", triangles_words(mesh)),
            None => format!("Part({} faces)", self.faces.len()),
        }
    }
}

#[pymethods]
impl Face {
    /// Number of the face, from 1.
    #[getter]
    fn number(&self) -> usize {
        self.0.face().number
    }

    /// Kind of surface.
    #[getter]
    fn kind(&self) -> &'static str {
        self.0.face().surface.kind()
    }

    /// True if the cutter is on the side opposite to S_u x S_v.
    #[getter]
    fn flip(&self) -> bool {
        self.0.face().flip
    }

    /// Ranges of u and v, (2, 2).
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, self.0.face().bounds().map(Interval::ends).as_flattened().to_vec(), &[2, 2])
    }

    /// Area [mm2], good to about 1e-3.
    #[getter]
    fn area(&self) -> f64 {
        inspect::summary(self.0.face()).area
    }

    /// Radius of the tightest hollow on the cutter side [mm]; infinite where the face is nowhere hollow.
    #[getter]
    fn concave_radius(&self) -> f64 {
        inspect::summary(self.0.face()).concave_radius.unwrap_or(f64::INFINITY)
    }

    /// Returns the face with the cutter on its other side.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> face = trunnion.Part.from_net([[[0, 0, 0], [0, 8, 0]], [[4, 0, 0], [4, 8, 0]]]).faces[0]
    ///     >>> float(face.flipped().normal([0.5, 0.5])[2])
    ///     -1.0
    fn flipped(&self, py: Python<'_>) -> PyResult<Self> {
        Self::index(py, self.0.face().clone().flipped())
    }

    /// Returns points of the surface.
    ///
    /// Args:
    ///     uv: parameters, (2,) or (n, 2).
    ///
    /// Returns:
    ///     (3,) or (n, 3) [mm].
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> face = trunnion.Part.from_net([[[0, 0, 0], [0, 8, 0]], [[4, 0, 0], [4, 8, 0]]]).faces[0]
    ///     >>> face.point([[0, 0], [1, 1]]).tolist()
    ///     [[0.0, 0.0, 0.0], [4.0, 8.0, 0.0]]
    fn point<'py>(&self, uv: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.each(uv, |face, [u, v]| face.point(u, v).coords.into())
    }

    /// Returns unit normals on the cutter side for parameters uv, (3,) or (n, 3); NaN where there is none.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> face = trunnion.Part.from_net([[[0, 0, 0], [0, 8, 0]], [[4, 0, 0], [4, 8, 0]]]).faces[0]
    ///     >>> face.normal([0.5, 0.5]).tolist()
    ///     [0.0, 0.0, 1.0]
    fn normal<'py>(&self, uv: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.each(uv, |face, [u, v]| {
            face.normal(u, v).map_or([f64::NAN; 3], |normal| normal.into_inner().into())
        })
    }

    /// Returns S, S_u, S_v, S_uu, S_uv, S_vv for parameters uv, (6, 3) or (n, 6, 3).
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> face = trunnion.Part.from_net([[[0, 0, 0], [0, 8, 0]], [[4, 0, 0], [4, 8, 0]]]).faces[0]
    ///     >>> face.derivatives([0.5, 0.5])[1:3].tolist()
    ///     [[4.0, 0.0, 0.0], [0.0, 8.0, 0.0]]
    fn derivatives<'py>(&self, uv: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let (py, arrays) = (uv.py(), Numbers::of("uv", uv)?);
        let flat: Vec<[f64; 18]> = self.parallel(&arrays, |face, [u, v]| {
            let jet = face.surface.jet2(u, v);
            let mut row = [0.0; 18];
            let vectors = [jet.s.coords, jet.su, jet.sv, jet.suu, jet.suv, jet.svv];
            for (to, vector) in row.as_chunks_mut::<3>().0.iter_mut().zip(vectors) {
                *to = vector.into();
            }
            row
        })?;
        shaped_like(py, &arrays, flat.into_flattened(), &[6, 3])
    }

    /// Returns the principal curvatures, smaller first, positive where the face is hollow for the cutter.
    ///
    /// Args:
    ///     uv: parameters, (2,) or (n, 2).
    ///
    /// Returns:
    ///     (2,) or (n, 2) [1/mm].
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> net = [[[x, y, 0.01 * y * y] for y in (-9, -3, 3, 9)] for x in (0, 5)]
    ///     >>> face = trunnion.Part.from_net(net).faces[0]
    ///     >>> low, high = face.curvature([0.5, 0.5])
    ///     >>> bool(abs(low) < 1e-12 and high > 0.01)
    ///     True
    fn curvature<'py>(&self, uv: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.each(uv, |face, [u, v]| {
            let turned = if face.flip { -1.0 } else { 1.0 };
            let found = face.surface.jet2(u, v).curvature();
            let mut both =
                found.map_or([f64::NAN; 2], |both| [turned * both.min, turned * both.max]);
            both.sort_by(f64::total_cmp);
            both
        })
    }

    /// Returns the closest points of the face.
    ///
    /// Args:
    ///     points: (3,) or (n, 3) [mm].
    ///
    /// Returns:
    ///     uv (n, 2), points (n, 3) [mm], and distances (n,) [mm], positive on the cutter side.
    ///
    /// Raises:
    ///     InputError: the search was given up for a point.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> face = trunnion.Part.from_net([[[0, 0, 0], [0, 8, 0]], [[4, 0, 0], [4, 8, 0]]]).faces[0]
    ///     >>> uv, point, distance = face.closest([1.0, 2.0, 3.0])
    ///     >>> round(distance, 9)
    ///     3.0
    fn closest<'py>(
        &self,
        points: &Bound<'py, PyAny>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (py, arrays) = (points.py(), Numbers::of("points", points)?);
        arrays.shaped("points", &[&[3], &[0, 3]])?;
        let (rows, index) = (arrays.rows::<3>(), &self.0);
        let find = |point: &[f64; 3]| index.closest(&Point3::from(*point));
        let watch = StageWatch { stage: "searching closest points", callable: None };
        let found = in_slices(py, watch, rows, |slice| slice.par_iter().map(find).collect())?;
        let mut columns = (Vec::new(), Vec::new(), Vec::new());
        for (at, foot) in found.into_iter().enumerate() {
            let foot = foot.map_err(|error| input(py, format!("points[{at}]: {error}")))?;
            columns.0.extend([foot.uv.u, foot.uv.v]);
            columns.1.extend(<[f64; 3]>::from(foot.point.coords));
            columns.2.push(foot.distance);
        }
        Ok((
            shaped_like(py, &arrays, columns.0, &[2])?,
            shaped_like(py, &arrays, columns.1, &[3])?,
            shaped_like(py, &arrays, columns.2, &[])?,
        ))
    }

    /// Returns vertices (v, 3) [mm] and corners (t, 3) of triangles within about `chord` [mm] of the face.
    ///
    /// Example:
    ///     >>> import trunnion
    ///     >>> face = trunnion.Part.from_net([[[0, 0, 0], [0, 8, 0]], [[4, 0, 0], [4, 8, 0]]]).faces[0]
    ///     >>> vertices, triangles = face.mesh(0.1)
    ///     >>> triangles.shape[1], float(vertices[:, 1].max())
    ///     (3, 8.0)
    #[pyo3(signature = (chord=0.01))]
    fn mesh<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = scalar)] chord: f64,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let chord = positive(py, "chord", chord)?;
        let face = self.0.face();
        let made = py.detach(|| face.tessellate(chord));
        mesh_arrays(py, &made.map_err(|error| input(py, error))?.mesh)
    }

    fn __repr__(&self) -> String {
        format!("Face({}, {})", self.number(), self.kind())
    }
}

impl Face {
    fn index(py: Python<'_>, face: LibraryFace) -> PyResult<Self> {
        let made = py.detach(|| FaceIndex::new(face));
        made.map(|index| Self(Arc::new(index))).map_err(|error| input(py, error))
    }

    /// Computes a row for each pair of parameters.
    fn each<'py, const N: usize>(
        &self,
        uv: &Bound<'py, PyAny>,
        row: impl Fn(&LibraryFace, [f64; 2]) -> [f64; N] + Sync + Send,
    ) -> PyResult<Bound<'py, PyAny>> {
        let arrays = Numbers::of("uv", uv)?;
        let rows = self.parallel(&arrays, row)?;
        shaped_like(uv.py(), &arrays, rows.into_flattened(), &[N])
    }

    fn parallel<const N: usize>(
        &self,
        arrays: &Numbers<'_>,
        row: impl Fn(&LibraryFace, [f64; 2]) -> [f64; N] + Sync + Send,
    ) -> PyResult<Vec<[f64; N]>> {
        arrays.shaped("uv", &[&[2], &[0, 2]])?;
        let (pairs, face) = (arrays.rows::<2>(), self.0.face());
        let watch = StageWatch { stage: "evaluating the face", callable: None };
        let all = |slice: &[[f64; 2]]| slice.par_iter().map(|uv| row(face, *uv)).collect();
        in_slices(arrays.python(), watch, pairs, all)
    }
}

/// Returns rows of `inner` shape, as many as the argument has, or one without a row index.
fn shaped_like<'py>(
    py: Python<'py>,
    arrays: &Numbers<'_>,
    values: Vec<f64>,
    inner: &[usize],
) -> PyResult<Bound<'py, PyAny>> {
    let shape = arrays.shape();
    let mut outer = shape[..shape.len() - 1].to_vec();
    outer.extend(inner);
    if outer.is_empty() {
        let value = values.first().copied().unwrap_or(f64::NAN);
        return Ok(value.into_pyobject(py)?.into_any());
    }
    array(py, values, &outer)
}

/// Returns vertices and triangles of a mesh.
pub(crate) fn mesh_arrays<'py>(
    py: Python<'py>,
    mesh: &Mesh,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    let vertices: Vec<f64> =
        mesh.vertices.iter().flat_map(|point| <[f64; 3]>::from(point.coords)).collect();
    let corners: Vec<i64> = mesh.triangles.iter().flatten().map(|at| i64::from(*at)).collect();
    let triangles = crate::arrays::whole(py, corners);
    let triangles = triangles.call_method1("reshape", (mesh.triangles.len(), 3))?;
    Ok((array(py, vertices, &[mesh.vertices.len(), 3])?, triangles))
}

fn no_part(source: &Bound<'_, PyAny>) -> PyErr {
    let name = source.get_type().name();
    let value = name.map_or_else(|_| "?".to_owned(), |name| name.to_string());
    let (defect, remedy) = ("is no part", "give the path of a STEP, STL or surface JSON file");
    WrongArgument { name: "path", index: &[], value, defect, remedy }.error(source.py())
}

/// Joins meshes into one.
pub(crate) fn joined<'a>(all: impl IntoIterator<Item = &'a Mesh>) -> Mesh {
    let mut whole = Mesh::default();
    for mesh in all {
        let first = u32::try_from(whole.vertices.len()).unwrap_or(u32::MAX);
        whole.vertices.extend_from_slice(&mesh.vertices);
        let moved = |corners: &[u32; 3]| corners.map(|corner| corner.saturating_add(first));
        whole.triangles.extend(mesh.triangles.iter().map(moved));
    }
    whole
}

fn triangles_words(mesh: &Mesh) -> String {
    format!("{} triangles, no faces", mesh.triangles.len())
}

/// Returns the clamped knot vector with equal spans from 0 to 1.
fn uniform(points: usize, degree: usize) -> Vec<f64> {
    let spans = points - degree;
    let inner = (1..spans).map(|knot| knot as f64 / spans as f64);
    let ends = |value| std::iter::repeat_n(value, degree + 1);
    ends(0.0).chain(inner).chain(ends(1.0)).collect()
}
