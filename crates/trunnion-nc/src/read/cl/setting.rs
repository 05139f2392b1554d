//! Units, tools, feeds and frames of CL files.

use super::file::ClItem;
use super::reader::{ClReader, no_number, shortened};
use super::state::{ClResult, PathShape};
use super::statement::LARGEST;
use super::statement::{ClWord, Numbers, Statement};
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, UnitVector3, Vector3};

/// Millimetres in an inch, by definition.
pub(super) const INCH: f64 = 25.4;

/// Lengths and angles of written axes: six decimals leave 1e-6, four 1e-4.
const FRAME_SLACK: f64 = 1e-3;

impl ClReader {
    /// Reads `$$->`, a comment that Creo uses as a statement.
    pub(super) fn directive(&mut self, statement: &Statement<'_>) -> ClResult<ClItem> {
        let at = statement.text.find("$$->").map_or(0, |at| at + 4);
        let text = statement.text.get(at..).unwrap_or_default();
        let (name, list) = text.split_once('/').unwrap_or((text, ""));
        let list = ClWord { text: list, at: at + name.len() + 1 };
        match name.trim().to_ascii_uppercase().as_str() {
            "CUTTER" => self.set_cutter(list),
            "CSYS" => {
                let numbers = Numbers::of(list).map_err(|word| no_number(statement, word))?;
                let written = format!("{:?}", numbers.as_slice());
                if self.state.directive.as_ref().is_some_and(|before| *before != written) {
                    let message =
                        "the coordinate system changes; all locations are taken to be in one";
                    self.warn(statement, "$$->CSYS", message.to_owned(), "");
                }
                self.state.directive = Some(written);
            }
            _ => {}
        }
        Ok(ClItem::Words)
    }

    pub(super) fn units(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<()> {
        let unit = rest.items().next().unwrap_or(rest);
        self.state.scale = match unit.text.to_ascii_uppercase().as_str() {
            "MM" | "MMS" | "MILLIMETERS" => 1.0,
            "CM" => 10.0,
            "INCH" | "INCHES" | "IN" => INCH,
            other => {
                let message = format!("unit {other:?} is not known");
                return Err(Box::new(of.fault(unit.at, message, "write UNITS/MM or UNITS/INCHES")));
            }
        };
        self.state.units = true;
        Ok(())
    }

    /// Reads `FEDRAT`: per minute, or per revolution of the spindle.
    pub(super) fn feed_rate(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<ClItem> {
        // Value and unit come in either order: FEDRAT/800,MMPM or FEDRAT/MMPM,800.
        let (mut value, mut scale, mut turns) = (None, self.state.scale, false);
        for word in rest.items() {
            match word.text.to_ascii_uppercase().as_str() {
                "MMPM" => scale = 1.0,
                "IPM" => scale = INCH,
                "PERMIN" | "LENGTH" => {}
                "MMPR" => (scale, turns) = (1.0, true),
                "IPR" => (scale, turns) = (INCH, true),
                "PERREV" => turns = true,
                _ if value.is_none() => {
                    value = Some((word, word.number().filter(|feed| *feed > 0.0)));
                }
                _ => {}
            }
        }
        let Some((word, Some(feed))) = value else {
            let word = value.map_or(rest, |(word, _)| word);
            let message =
                format!("{:?} is no feed above 0 and up to {LARGEST}", shortened(word.text));
            return Err(Box::new(of.fault(word.at, message, "write FEDRAT/800.0,MMPM")));
        };
        // An inch feed suggests inch coordinates, which nothing has declared yet.
        if !self.state.units && scale > 1.0 {
            let message = "a feed in inches, and no UNITS before it".to_owned();
            let help = "write UNITS/INCHES, or UNITS/MM, before the first location";
            return Err(Box::new(of.fault(word.at, message, help)));
        }
        let turns = match (turns, self.state.spindle) {
            // Per minute to per second; per revolution times revolutions per second.
            (false, _) => 1.0 / 60.0,
            (true, Some(spindle)) => spindle,
            (true, None) => {
                let message = "a feed per revolution, and no SPINDL before it".to_owned();
                return Err(Box::new(of.fault(
                    word.at,
                    message,
                    "write SPINDL/8000,RPM before it",
                )));
            }
        };
        self.state.feed = Some(feed * scale * turns);
        self.state.rapid = false;
        self.state.shape.leave();
        Ok(ClItem::Manner)
    }

    pub(super) fn spindle(&mut self, rest: ClWord<'_>) {
        // A cutting speed gives no spindle speed without the engaged diameter.
        if rest.items().any(|word| word.is("SFM") || word.is("SMM")) {
            self.state.spindle = None;
            return;
        }
        let turns = rest.items().find_map(|word| word.number());
        if let Some(turns) = turns.filter(|turns| *turns > 0.0) {
            self.state.spindle = Some(turns / 60.0);
        }
    }

    pub(super) fn set_cutter(&mut self, rest: ClWord<'_>) {
        let mut numbers = rest.items().filter_map(|word| word.number());
        if let Some(diameter) = numbers.next() {
            let corner = numbers.next().unwrap_or(0.0);
            self.state.cutter = Some([diameter, corner]);
        }
    }

    /// Reads `TLDATA`: kind of tool, diameter, and corner radius; drills have a point angle instead
    /// of the latter.
    pub(super) fn tool_data(&mut self, rest: ClWord<'_>) {
        let mill = rest.items().next().is_some_and(|word| word.is("MILL"));
        self.set_cutter(rest);
        if let (false, Some(cutter)) = (mill, &mut self.state.cutter) {
            cutter[1] = 0.0;
        }
    }

    pub(super) fn set_tool(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<()> {
        // `5.` and `5.0000` are written, too.
        let whole = |word: ClWord<'_>| {
            let number = word.number().filter(|n| n.fract().abs() <= 0.0 && *n >= 0.0)?;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole")]
            let number = number as u32;
            Some(number)
        };
        let number = rest.items().find_map(whole);
        if number.is_none() {
            let message = format!("{:?} names no tool", shortened(rest.text));
            return Err(Box::new(of.fault(rest.at, message, "write LOADTL/5")));
        }
        self.state.tool = number;
        Ok(())
    }

    pub(super) fn tool_axis(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<()> {
        let numbers = Numbers::of(rest).map_err(|word| no_number(of, word))?;
        if let [i, j, k] = *numbers.as_slice() {
            self.state.axis = self.axis_of(of, rest.at, Vector3::new(i, j, k))?;
            return Ok(());
        }
        Err(Box::new(of.fault(rest.at, "TLAXIS needs three numbers".to_owned(), "")))
    }

    /// Reads `MSYS`: origin, x and y axis of the coordinates from here on.
    pub(super) fn frame(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<()> {
        let numbers = Numbers::of(rest).map_err(|word| no_number(of, word))?;
        let [ox, oy, oz, xx, xy, xz, yx, yy, yz] = *numbers.as_slice() else {
            let message = format!("MSYS has {} numbers; 9 are needed", numbers.as_slice().len());
            return Err(Box::new(of.fault(rest.at, message, "origin, x axis, y axis")));
        };
        let [x, y] = [Vector3::new(xx, xy, xz), Vector3::new(yx, yy, yz)];
        let turn = rotation(of, rest.at, [x, y])?;
        let origin = Vector3::new(ox, oy, oz) * self.state.scale;
        let frame = Isometry3::from_parts(Translation3::from(origin), turn);
        if self.state.first_frame.is_none() && self.state.place.is_some() {
            let message = "MSYS behind locations that are in none".to_owned();
            let help = "write the MSYS of the first locations before them";
            return Err(Box::new(of.fault(rest.at, message, help)));
        }
        // All locations are given in the first frame of the file.
        self.state.first_frame.get_or_insert(frame);
        if self.state.frame != frame {
            // Where the tool stands is not known in the new coordinates.
            self.state.place = None;
        }
        self.state.frame = frame;
        self.new_axis(Vector3::z_axis());
        Ok(())
    }

    /// Reads `CSYS`: rows of the matrix whose columns are its axes and its origin. Locations are
    /// not in it.
    pub(super) fn world(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<()> {
        let numbers = Numbers::of(rest).map_err(|word| no_number(of, word))?;
        let [xx, yx, zx, _, xy, yy, zy, _, xz, yz, zz, _] = *numbers.as_slice() else {
            let message = format!("CSYS has {} numbers; 12 are needed", numbers.as_slice().len());
            return Err(Box::new(of.fault(rest.at, message, "three rows of four")));
        };
        let turn = rotation(of, rest.at, [Vector3::new(xx, xy, xz), Vector3::new(yx, yy, yz)])?;
        // The matrix has the third axis as well: a check that rows and columns were not swapped.
        let axis = turn * Vector3::z_axis();
        if (*axis - Vector3::new(zx, zy, zz)).norm() > FRAME_SLACK {
            let message = "CSYS: the third axis does not stand on the two others".to_owned();
            return Err(Box::new(of.fault(rest.at, message, "")));
        }
        if !self.state.world {
            let message =
                "TRNTYP is not WORLD: whether locations are in the CSYS is not known".to_owned();
            return Err(Box::new(of.fault(rest.at, message, "post in world coordinates")));
        }
        self.new_axis(axis);
        Ok(())
    }

    pub(super) fn transform(&mut self, of: &Statement<'_>, rest: ClWord<'_>) -> ClResult<()> {
        let kind = rest.items().next().unwrap_or(rest);
        self.state.world = kind.is("WORLD");
        if self.state.world {
            return Ok(());
        }
        let message = format!("TRNTYP/{}: only WORLD is understood", shortened(kind.text));
        Err(Box::new(of.fault(kind.at, message, "post in world coordinates")))
    }

    pub(super) fn new_axis(&mut self, axis: UnitVector3<f64>) {
        self.state.frame_axis = axis;
        self.state.axis = axis;
        self.state.shape = PathShape::Straight;
    }
}

/// Returns the rotation with these x and y axes, which must be unit and square.
fn rotation(
    of: &Statement<'_>,
    at: usize,
    [x, y]: [Vector3<f64>; 2],
) -> ClResult<UnitQuaternion<f64>> {
    let off = [x.norm() - 1.0, y.norm() - 1.0, x.dot(&y)];
    if off.iter().any(|off| off.abs() > FRAME_SLACK) {
        let message = "the axes of the coordinate system are not unit and square".to_owned();
        return Err(Box::new(of.fault(at, message, "")));
    }
    let x = x.normalize();
    // x as written, z square to both, y from them: rounding errors leave no skew.
    let z = x.cross(&y).normalize();
    let axes = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]));
    Ok(UnitQuaternion::from_rotation_matrix(&axes))
}
