//! Tables of sphere readings for a calibration: columns with their units in the names.

use super::table::{TableHeader, is_row};
use crate::calibrate::{ReadingKind, SphereReading};
use crate::machine::{AxisKind, Machine};
use crate::types::{AxisVector, Diagnostic, Diagnostics};
use nalgebra::Vector3;

/// Millimetres in an inch.
const INCH: f64 = 25.4;

/// Distance outside the travel that is still a reading \[mm or rad\]: software limits yield a little.
const BEYOND: f64 = 0.01;

/// Readings of a table.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct MeasurementTable {
    /// Readings in the order of rows.
    pub readings: Vec<SphereReading>,
    /// Line of each reading.
    pub lines: Vec<u64>,
    /// Names of the spheres by their index in the readings, as the tables number them.
    pub spheres: Vec<f64>,
}

/// A column of the table: its name there, and the factor to mm or rad.
struct UnitColumn {
    name: String,
    factor: f64,
}

/// Columns of a table of readings.
struct MeasurementColumns {
    axes: Vec<UnitColumn>,
    length: Option<UnitColumn>,
    sphere: bool,
    deviation: Option<[UnitColumn; 3]>,
    radius: Option<UnitColumn>,
}

impl MeasurementTable {
    /// Adds the readings of a table; spheres of the same number are the same in all tables.
    ///
    /// Columns: each axis with its unit (`X_mm` or `X_inch`, `C_deg` or `C_rad`); `length_mm`, gauge point to tip, else
    /// `tool_length` \[mm\] holds; `sphere`, its number, else 1. A row states that the tip is at the centre of the sphere,
    /// or off it by `dx_mm,dy_mm,dz_mm` in the workpiece frame, or at the distance `radius_mm` from it.
    ///
    /// # Errors
    ///
    /// Every missing column and row that cannot be used, with its line.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::files::machine::{built_in, parse};
    /// use trunnion::files::measurements::MeasurementTable;
    ///
    /// let text = built_in("bc-trunnion").map_err(|_| "no such machine")?;
    /// let machine = parse(text).map_err(|faults| faults.to_string())?.machine;
    /// let mut table = MeasurementTable::default();
    /// let rows = "X_mm,Y_mm,Z_mm,C_deg,B_deg\n-381,-200,-300,90,0\n";
    /// table.add(rows, &machine, 120.0).map_err(|faults| faults.to_string())?;
    /// assert_eq!(table.readings[0].tool_length, 120.0);
    /// # Ok::<(), String>(())
    /// ```
    pub fn add(
        &mut self,
        text: &str,
        machine: &Machine,
        tool_length: f64,
    ) -> Result<(), Diagnostics> {
        let mut lines = (1_u64..).zip(text.lines()).filter(|(_, line)| is_row(line));
        let Some((line, header)) = lines.next() else {
            return Err(Diagnostic::whole("the table is empty")
                .with_help("its first line names the columns, such as X_mm,Y_mm,Z_mm,C_deg,B_deg")
                .into());
        };
        let header = TableHeader::parse(line, header).map_err(Diagnostics::from)?;
        let columns = MeasurementColumns::of(&header, machine, line)?;
        let wanted = columns.wanted();
        let wanted: Vec<&str> = wanted.iter().map(String::as_str).collect();
        let selected = header.columns(&wanted)?;
        let (mut faults, mut values) = (Vec::new(), Vec::new());
        for (line, row) in lines {
            let read = selected.read(line, row, &mut values);
            let reading = read.and_then(|()| self.reading(&columns, &values, tool_length));
            match reading.and_then(|reading| inside(machine, reading, line)) {
                Ok(reading) => {
                    self.readings.push(reading);
                    self.lines.push(line);
                }
                Err(fault) => faults.push(fault.on_line(line)),
            }
        }
        if faults.is_empty() { Ok(()) } else { Err(faults.into()) }
    }

    /// Makes a reading of the values of a row.
    fn reading(
        &mut self,
        columns: &MeasurementColumns,
        values: &[f64],
        tool_length: f64,
    ) -> Result<SphereReading, Diagnostic> {
        let mut values = values.iter().copied();
        let mut next = || values.next().unwrap_or_default();
        let mut q = AxisVector::zeros();
        for (value, column) in q.iter_mut().zip(&columns.axes) {
            *value = next() * column.factor;
        }
        let tool_length = columns.length.as_ref().map_or(tool_length, |of| next() * of.factor);
        let sphere = if columns.sphere { next() } else { 1.0 };
        let kind = if let Some(radius) = &columns.radius {
            ReadingKind::Radius { radius: next() * radius.factor }
        } else {
            let deviation = columns.deviation.as_ref();
            let deviation = deviation.map(|of| of.each_ref().map(|part| next() * part.factor));
            ReadingKind::Center { deviation: Vector3::from(deviation.unwrap_or_default()) }
        };
        if let ReadingKind::Radius { radius } = kind
            && radius <= 0.0
        {
            let message = format!("the radius {radius} mm of the ball bar is not above 0");
            return Err(Diagnostic::whole(message).with_help("write the distance of both centres"));
        }
        Ok(SphereReading { q, tool_length, sphere: self.sphere(sphere), kind })
    }

    /// Returns the index of the sphere of that number.
    fn sphere(&mut self, number: f64) -> usize {
        let known = self.spheres.iter().position(|one| one.to_bits() == number.to_bits());
        known.unwrap_or_else(|| {
            self.spheres.push(number);
            self.spheres.len() - 1
        })
    }
}

impl MeasurementColumns {
    fn of(header: &TableHeader, machine: &Machine, line: u64) -> Result<Self, Diagnostics> {
        let mut faults = Vec::new();
        let mut axes = Vec::new();
        for axis in &machine.axes {
            let units = match axis.kind {
                AxisKind::Linear => LENGTHS,
                AxisKind::Rotary => ANGLES,
            };
            match with_unit(header, &axis.name, units) {
                Some(column) => axes.push(column),
                None => faults.push(missing(header, &axis.name, units).on_line(line)),
            }
        }
        let length = |name: &str| with_unit(header, name, LENGTHS);
        let deviation = match [length("dx"), length("dy"), length("dz")] {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            [None, None, None] => None,
            _ => {
                let message = "of the deviation dx_mm,dy_mm,dz_mm some columns are missing";
                faults.push(Diagnostic::whole(message).with_help("give all three").on_line(line));
                None
            }
        };
        let radius = length("radius");
        if radius.is_some() && deviation.is_some() {
            let message = "the table has a radius and a deviation of the centre";
            let help = "ball-bar radii and sphere centres go into two tables";
            faults.push(Diagnostic::whole(message).with_help(help).on_line(line));
        }
        let sphere = header.names().iter().any(|name| name == "sphere");
        let columns = Self { axes, length: length("length"), sphere, deviation, radius };
        if faults.is_empty() { Ok(columns) } else { Err(faults.into()) }
    }

    /// Returns the names in the order of reading.
    fn wanted(&self) -> Vec<String> {
        let name = |column: &UnitColumn| column.name.clone();
        let mut names: Vec<String> = self.axes.iter().map(name).collect();
        names.extend(self.length.as_ref().map(name));
        names.extend(self.sphere.then(|| "sphere".to_owned()));
        match (&self.radius, &self.deviation) {
            (Some(radius), _) => names.push(name(radius)),
            (None, deviation) => names.extend(deviation.iter().flatten().map(name)),
        }
        names
    }
}

/// Unit that the name of a column may end with.
#[derive(Debug, Clone, Copy)]
struct ColumnUnit {
    name: &'static str,
    /// One of it in mm or rad.
    factor: f64,
}

const LENGTHS: [ColumnUnit; 2] =
    [ColumnUnit { name: "mm", factor: 1.0 }, ColumnUnit { name: "inch", factor: INCH }];
const ANGLES: [ColumnUnit; 2] = [
    ColumnUnit { name: "deg", factor: std::f64::consts::PI / 180.0 },
    ColumnUnit { name: "rad", factor: 1.0 },
];

fn with_unit(header: &TableHeader, name: &str, units: [ColumnUnit; 2]) -> Option<UnitColumn> {
    units.into_iter().find_map(|unit| {
        let name = format!("{name}_{}", unit.name);
        header.names().contains(&name).then_some(UnitColumn { name, factor: unit.factor })
    })
}

fn missing(header: &TableHeader, name: &str, units: [ColumnUnit; 2]) -> Diagnostic {
    let [first, second] = units.map(|unit| format!("{name}_{}", unit.name));
    let bare = header.names().iter().any(|here| here == name);
    let message = if bare {
        format!("column {name} states no unit")
    } else {
        format!("there is no column for axis {name}")
    };
    Diagnostic::whole(message).with_help(format!("call it {first} or {second}"))
}

/// Refuses a position that the machine cannot have had.
fn inside(
    machine: &Machine,
    reading: SphereReading,
    line: u64,
) -> Result<SphereReading, Diagnostic> {
    match machine.out_of_travel(&reading.q) {
        Some(out) if out.excess > BEYOND => Err(Diagnostic::whole(out.to_string())
            .with_help("a reading is where the machine was: correct unit, sign or column, or the travel in the machine file")
            .on_line(line)),
        _ => Ok(reading),
    }
}

#[cfg(test)]
mod tests {
    use super::super::machine::{built_in, parse};
    use super::*;

    fn faults(text: &str) -> String {
        let machine = parse(built_in("bc-trunnion").unwrap()).unwrap().machine;
        let mut table = MeasurementTable::default();
        table.add(text, &machine, 0.0).map_or_else(|faults| faults.to_string(), |()| String::new())
    }

    #[test]
    fn faults_have_a_line_and_a_remedy() {
        let head = "X_mm,Y_mm,Z_mm,C_deg,B_deg";
        for (text, expected) in [
            ("# nothing\n".to_owned(), "the table is empty"),
            (
                "X,Y_mm,Z_mm,C_deg,B_deg\n".to_owned(),
                "1: column X states no unit\n  help: call it X_mm or X_inch",
            ),
            ("X_mm,Y_mm,Z_mm,B_deg\n".to_owned(), "1: there is no column for axis C"),
            (format!("{head}\n1,-1,-1,1,1\n"), "2: X = 1.0000 mm is outside its travel"),
            (format!("{head}\n-1,-1,-1,1,x\n"), "2:12: B_deg = \"x\" is not a number"),
            (
                format!("{head},dx_mm\n"),
                "1: of the deviation dx_mm,dy_mm,dz_mm some columns are missing",
            ),
            (format!("{head},radius_mm\n-1,-1,-1,1,1,0\n"), "2: the radius 0 mm of the ball bar"),
        ] {
            let found = faults(&text);
            assert!(found.contains(expected), "{found}");
        }
    }

    #[test]
    fn units_and_spheres_are_read() {
        let machine = parse(built_in("bc-trunnion").unwrap()).unwrap().machine;
        let mut table = MeasurementTable::default();
        let text = "sphere,B_rad,C_deg,X_inch,Y_mm,Z_mm,length_inch,dx_mm,dy_mm,dz_mm\n7,1,180,-1,-2,-3,4,1,2,3\n9,1,180,-1,-2,-3,4,0,0,0\n";
        table.add(text, &machine, 0.0).unwrap();
        let [first, second] = table.readings[..] else { panic!("two rows") };
        assert!(
            (first.q[0] + 25.4).abs() < 1e-12 && (first.q[3] - std::f64::consts::PI).abs() < 1e-15
        );
        assert!((first.tool_length - 101.6).abs() < 1e-12);
        assert_eq!(
            (first.sphere, second.sphere, table.spheres.as_slice()),
            (0, 1, &[7.0, 9.0][..])
        );
        assert_eq!(first.kind, ReadingKind::Center { deviation: Vector3::new(1.0, 2.0, 3.0) });
    }
}
