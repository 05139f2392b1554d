//! Moves of a LinuxCNC program by trunnion's reader, from machine zero: `cut|rapid X Y Z length`, mm.
//!
//! `moves PROGRAM LETTERS [--tools TABLE UNIT] [--ini FILE] [--sub-dir FOLDER]... [--block-delete]`. The machine is plain:
//! axis position = word + work offset + tool length along Z, and every offset is zero until the program writes it.
//! Exit 2, with the refusal on stderr: the reader refuses the program; the moves before the refusal are printed.

use std::fs;
use std::path::Path;
use std::process::ExitCode;
use trunnion_nc::read::{
    AxisWord, AxisWords, Dialect, Frame, Move, Offset, OffsetKind, Pace, ReadOptions, Step,
    SubprogramFile, ToolRow, Way, ini_file, steps, tool_rows,
};

/// A machine whose axes are its words.
struct PlainMachine {
    at: [f64; 5],
    origins: [[f64; 5]; 16],
    tools: Vec<ToolRow>,
    length: f64,
}

impl PlainMachine {
    fn take(&mut self, step: &Step) {
        match step {
            Step::Move(step) => self.go(step),
            Step::Tool { number, .. } => {
                let row = self.tools.iter().find(|row| row.number == *number);
                self.length = row.map_or(0.0, |row| row.offset[2]);
            }
            Step::Offset(offset) => self.write(offset),
            _ => {}
        }
    }

    fn write(&mut self, offset: &Offset) {
        let Some(origin) = self.origins.get_mut(usize::from(offset.offset)) else { return };
        for (slot, word) in offset.words.into_iter().enumerate() {
            match (word, offset.kind) {
                (Some(word), OffsetKind::Origin) => origin[slot] = word,
                (Some(word), OffsetKind::Reading) => origin[slot] = self.at[slot] - word,
                _ => {}
            }
        }
    }

    fn go(&mut self, step: &Move) {
        let before = self.at;
        for (slot, word) in step.words.into_iter().enumerate() {
            let Some(word) = word else { continue };
            let from = match step.frame {
                _ if step.incremental => self.at[slot],
                Frame::Machine => 0.0,
                Frame::Work { offset, length, .. } => {
                    let along = if length && slot == 2 { self.length } else { 0.0 };
                    self.origins.get(usize::from(offset)).map_or(0.0, |origin| origin[slot]) + along
                }
            };
            self.at[slot] = from + word;
        }
        let change: Vec<f64> = before.iter().zip(self.at).map(|(from, to)| to - from).collect();
        let length = match step.way {
            Way::Line => change[..3].iter().map(|change| change * change).sum::<f64>().sqrt(),
            Way::Arc(arc) => {
                let along = (0..3)
                    .filter(|slot| !arc.plane.contains(slot))
                    .map(|slot| change[slot].powi(2));
                ((arc.radius() * arc.sweep).powi(2) + along.sum::<f64>()).sqrt()
            }
        };
        if length > 0.0 {
            let kind = if step.pace == Pace::Rapid { "rapid" } else { "cut" };
            let [x, y, z, ..] = self.at;
            println!("{kind} {x:.6} {y:.6} {z:.6} {length:.6} {}", step.line);
        }
    }
}

/// Five axes, X Y Z and two rotaries, by their letters.
fn axes(letters: &str) -> AxisWords {
    let mut axes = [AxisWord { letter: ' ', rotary: false, decimals: 4, reversed: false }; 5];
    for (word, letter) in axes.iter_mut().zip(letters.chars()) {
        (word.letter, word.rotary) = (letter, "ABC".contains(letter));
    }
    AxisWords(axes)
}

/// Files of a folder that a program may call.
fn subprograms(folder: &Path) -> Vec<SubprogramFile> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let files = entries.flatten().map(|entry| entry.path());
    let file = |path: std::path::PathBuf| {
        let name = path.file_stem()?.to_str()?.to_owned();
        let text = String::from_utf8_lossy(&fs::read(&path).ok()?).into_owned();
        (path.extension()? == "ngc").then_some(SubprogramFile { name, text })
    };
    files.filter_map(file).collect()
}

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().collect();
    let mut options = ReadOptions {
        sixth: true,
        start: Some([0.0; 5]),
        ..ReadOptions::new(Dialect::LinuxCnc, axes(&args[2]), 20)
    };
    let mut rest = args[3..].iter();
    while let Some(flag) = rest.next() {
        let mut value = || rest.next().expect("a value");
        match flag.as_str() {
            "--tools" => {
                let text = fs::read_to_string(value()).unwrap_or_default();
                let unit = value().parse().expect("a number");
                options.tools = tool_rows(&text, unit).unwrap_or_default();
            }
            "--ini" => {
                let ini = ini_file(&fs::read_to_string(value()).unwrap_or_default());
                options.parameters.extend(ini.parameters);
                // M428 and M429 are known without it.
                options.remaps.extend(
                    ini.remaps
                        .into_iter()
                        .filter(|remap| remap.subprogram.as_deref() != Some("nothing")),
                );
            }
            "--sub-dir" => options.subprograms.extend(subprograms(Path::new(value()))),
            _ => options.block_delete = Some(value() == "true"),
        }
    }
    let bytes = fs::read(&args[1]).unwrap_or_default();
    let text = String::from_utf8_lossy(&bytes);
    let mut machine = PlainMachine {
        at: [0.0; 5],
        origins: [[0.0; 5]; 16],
        tools: options.tools.clone(),
        length: 0.0,
    };
    machine.length = machine.tools.first().map_or(0.0, |row| row.offset[2]);
    for step in steps(text.lines(), &options) {
        match step {
            Ok(step) => machine.take(&step),
            Err(faults) => {
                faults.iter().for_each(|fault| eprintln!("{fault}"));
                return ExitCode::from(2);
            }
        }
    }
    ExitCode::SUCCESS
}
