//! The stock of a program as it is cut: changes of its surface as flat arrays.

use nalgebra::Point3;
use trunnion::verify::{StockBrick, StockChanges, TimedStock};
use trunnion_cli::calls::{StockSource, TimedStockAnswer};

/// Stock of a program as it is cut.
#[derive(Debug)]
pub struct StockModel(TimedStockAnswer);

/// Pieces of the surface of stock, one brick after the other.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct BrickModel {
    /// Number, vertices and triangles of each brick.
    pub counts: Vec<u32>,
    /// Vertices \[mm\], three numbers each.
    pub positions: Vec<f32>,
    /// Triangles, three indices each; every brick counts its own vertices.
    pub triangles: Vec<u32>,
}

impl StockModel {
    pub(crate) fn of(answer: TimedStockAnswer) -> Self {
        Self(answer)
    }

    /// Returns the largest distance of its rays \[mm\].
    pub fn cell(&self) -> f64 {
        self.0.cell.into_iter().fold(0.0, f64::max)
    }

    /// Returns true if the job or the options name it, false if the box of the part stands for it.
    pub fn is_stated(&self) -> bool {
        self.0.source == StockSource::Stated
    }

    /// Returns the stock itself.
    pub fn stock(&self) -> &TimedStock {
        &self.0.stock
    }

    /// Goes towards a time \[s\] by at most `moves` moves, and returns the time that it has come to \[s\].
    ///
    /// # Errors
    ///
    /// Words about a move that cannot be followed.
    pub fn cut(&mut self, time: f64, moves: usize) -> Result<f64, String> {
        self.0.stock.cut_towards(time, moves).map_err(|error| error.to_string())
    }

    /// Returns the bricks whose surface has changed since the last call, and all of them at the first one.
    ///
    /// # Errors
    ///
    /// Words about a move that cannot be followed.
    pub fn changes(&mut self) -> Result<BrickModel, String> {
        let changes = self.0.stock.changes().map_err(|error| error.to_string())?;
        Ok(BrickModel::of(&changes))
    }
}

impl BrickModel {
    fn of(changes: &StockChanges) -> Self {
        let mut model = Self::default();
        for StockBrick { number, mesh, .. } in &changes.bricks {
            // Counts of a page's picture: stock of 2^32 of anything has no memory there.
            let counts = [*number, mesh.vertices.len(), mesh.triangles.len()];
            model.counts.extend(counts.map(|count| u32::try_from(count).unwrap_or(u32::MAX)));
            model.positions.extend(mesh.vertices.iter().flat_map(drawn));
            model.triangles.extend(mesh.triangles.iter().flatten());
        }
        model
    }
}

#[expect(clippy::cast_possible_truncation, reason = "for a picture")]
fn drawn(point: &Point3<f64>) -> [f32; 3] {
    [point.x, point.y, point.z].map(|value| value as f32)
}

#[cfg(test)]
mod tests {
    use crate::{CHECK_FOLDER, Engine};
    use trunnion::types::Silent;

    /// Two tools: one inclined, which the control keeps on its way; one upright that comes down through the material at rapid
    /// speed and cuts an arc.
    const PROGRAM: &str = "G21 G90 G94 G17\nT1 M6\nG53 G0 Z0\nG0 B30 C20\nG43 H1 M428\nG0 X-30 Y0 Z40\nG1 Z-2 F2000\n\
         G1 X30 F1200\nM429\nG53 G0 Z0\nT2 M6\nG53 G0 Z0\nG0 B0 C0\nG43 H2 G0 X-12 Y-8\nG0 Z-2\nG1 X12 F1500\n\
         G3 X12 Y8 I0 J8\nG1 X-12\nG53 G0 Z0\nM30\n";
    const BLOCK: &str = "box:-25,-15,-12,25,15,0";

    fn options(cell: &str) -> Vec<String> {
        let words = format!(
            "part.ngc --machine bc-trunnion --origin=0,0,-430 --cutter 1=R=4,r=4 --tool-length 1=100 --cutter 2=R=3,r=0 --tool-length 2=80 \
             --stock {BLOCK}{cell}"
        );
        words.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn stock_of_a_program_is_cut_as_a_check_cuts_it() {
        let mut engine = Engine::default();
        engine.insert("part.ngc", PROGRAM.as_bytes().to_vec());
        let checked = engine.check(&options(" --stock-cell 0.4166666666666667"), &Silent);
        assert_ne!(checked.files, [""; 0], "{:?}", checked.messages);
        let summary = engine.file(&format!("{CHECK_FOLDER}/summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_slice(summary).unwrap();
        let removed = summary["stock"]["removed"].as_f64().unwrap();
        assert!(removed > 500.0, "{removed}");

        let timeline = engine.timeline(&options("")).unwrap();
        assert!(timeline.has_stock);
        let mut model = engine.stock(&options(""), 0.5).unwrap().unwrap();
        assert!(
            model.is_stated() && (model.cell() - 50.0 / 120.0).abs() < 0.01,
            "{}",
            model.cell()
        );
        let end = *timeline.times.last().unwrap();
        assert!((model.stock().end() - end).abs() < 1e-9);

        let first = model.changes().unwrap();
        let corners: u32 = first.counts.chunks(3).map(|brick| brick[1]).sum();
        assert_eq!(first.positions.len(), 3 * corners as usize);
        // The tilted pass, the rapid move down, two cuts, the end, and back.
        let after = |line: u32| {
            let last = timeline.lines.iter().rposition(|other| *other == line);
            timeline.times[last.unwrap()]
        };
        let times = [0.0, after(8), after(15), after(16), after(17), end, after(16), 0.0];
        let mut volumes = Vec::new();
        for time in times {
            assert!(model.cut(time, usize::MAX).unwrap() >= time - 1e-9);
            model.changes().unwrap();
            volumes.push(50.0 * 30.0 * 12.0 - model.stock().volume());
        }
        let cuts: Vec<f64> = volumes[..5].windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(volumes[0].abs() < 1e-6 && cuts.iter().all(|cut| *cut > 20.0), "{volumes:?}");
        assert!((volumes[5] / removed - 1.0).abs() < 1e-3, "{volumes:?}, {removed}");
        assert!((volumes[6] - volumes[3]).abs() < 0.1 && volumes[7].abs() < 1e-6, "{volumes:?}");
    }

    #[test]
    fn a_part_without_stock_is_cut_from_its_box() {
        let mut engine = Engine::default();
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../");
        for name in [
            "examples/bezier-patch/job.toml",
            "fixtures/bezier-patch/patch.json",
            "machines/bc-trunnion.toml",
        ] {
            engine.insert(name, std::fs::read(format!("{folder}{name}")).unwrap());
        }
        engine.insert(
            "edited.ngc",
            std::fs::read(format!("{folder}studio/samples/edited.ngc")).unwrap(),
        );
        let options = ["edited.ngc", "--job", "examples/bezier-patch/job.toml"].map(str::to_owned);
        let mut model = engine.stock(&options, 2.0).unwrap().unwrap();
        assert!(!model.is_stated());
        let whole = model.stock().volume();
        model.cut(f64::INFINITY, usize::MAX).unwrap();
        model.changes().unwrap();
        let left = model.stock().volume() / whole;
        assert!(left > 0.2 && left < 0.9, "{left} of the box is left");
        // A program without part and stock has nothing to cut.
        let bare = ["edited.ngc", "--machine", "machines/bc-trunnion.toml", "--tool-length", "120"];
        assert!(engine.stock(&bare.map(str::to_owned), 2.0).unwrap().is_none());
    }
}
