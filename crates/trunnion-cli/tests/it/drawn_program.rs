//! Random `LinuxCNC` programs as a shop writes them, with the motion that they command by their own reckoning.

use std::f64::consts::{PI, TAU};

/// Source of numbers that a seed repeats (`SplitMix64`).
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number of four decimals, as words have them.
    fn within(&mut self, low: f64, high: f64) -> f64 {
        let share = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        word(low + share * (high - low))
    }

    pub(crate) fn below(&mut self, count: u64) -> usize {
        usize::try_from(self.bits() % count).unwrap_or(0)
    }
}

/// The value of a word with four decimals.
fn word(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

/// A program, and what it commands.
pub(crate) struct DrawnProgram {
    pub(crate) text: String,
    pub(crate) tools: usize,
    /// Lengths of the moves with feed and of the rapid moves; `None` where the control divides a cycle by its own rule
    /// \[mm\].
    pub(crate) lengths: Option<[f64; 2]>,
    /// Time of the moves with feed \[s\].
    pub(crate) seconds: f64,
    at: [f64; 3],
    cut: f64,
    rapid: f64,
    has_pecks: bool,
}

impl DrawnProgram {
    /// A program under tool-centre-point control: both rotaries turn in every cut.
    pub(crate) fn five_axis(draw: &mut Draw) -> Self {
        let mut program = Self::new(draw);
        for tool in 1..=program.tools {
            program.call(draw, tool);
            let mut turn = [draw.within(10.0, 35.0), draw.within(-60.0, 60.0)];
            program.at = [draw.within(-30.0, 30.0), draw.within(-30.0, 30.0), 40.0];
            let [x, y, z] = program.at;
            program.line(&format!("M428\nG0 X{x} Y{y} Z{z} A{} C{}", turn[0], turn[1]));
            for _ in 0..=draw.below(4) {
                let feed = [100.0, 200.0, 300.0, 500.0][draw.below(4)];
                for _ in 0..3 + draw.below(18) {
                    let to = program.near(draw, [4.0, 4.0, 2.0]);
                    // In a shorter block the turn would be too much for the rotaries: the program would not be clean.
                    if distance(program.at, to) < 2.0 {
                        continue;
                    }
                    turn[0] = word((turn[0] + draw.within(-2.0, 2.0)).clamp(8.0, 40.0));
                    turn[1] = word(turn[1] + draw.within(-3.0, 3.0));
                    let [x, y, z] = to;
                    program.line(&format!("G1 X{x} Y{y} Z{z} A{} C{} F{feed}", turn[0], turn[1]));
                    program.feed(distance(program.at, to), feed);
                    program.at = to;
                }
                let [x, y, _] = program.at;
                program.go([x, y, 50.0], None);
                program.go([draw.within(-30.0, 30.0), draw.within(-30.0, 30.0), 50.0], None);
                let [x, y, _] = program.at;
                program.go([x, y, draw.within(10.0, 30.0)], None);
            }
            program.leave("M429\n");
        }
        program.end()
    }

    /// A program of lines, arcs, helices and drilling cycles along Z.
    pub(crate) fn three_axis(draw: &mut Draw) -> Self {
        let mut program = Self::new(draw);
        for tool in 1..=program.tools {
            program.call(draw, tool);
            program.at = [draw.within(-30.0, 30.0), draw.within(-30.0, 30.0), 50.0];
            let [x, y, z] = program.at;
            program.line(&format!("G0 X{x} Y{y} Z{z} A0 C0"));
            for _ in 0..2 + draw.below(4) {
                let feed = [100.0, 200.0, 300.0, 500.0][draw.below(4)];
                program.go([draw.within(-30.0, 30.0), draw.within(-30.0, 30.0), 50.0], None);
                match draw.below(4) {
                    0 => program.lines(draw, feed),
                    1 => program.arcs(draw, feed),
                    2 => program.holes(draw, feed),
                    _ => program.peck(draw, feed),
                }
                let [x, y, _] = program.at;
                program.go([x, y, 50.0], None);
            }
            program.leave("");
        }
        program.end()
    }

    fn new(draw: &mut Draw) -> Self {
        Self {
            text: "G21 G90 G17 G40 G80 G54 G94\n".to_owned(),
            tools: [1, 1, 2, 3][draw.below(4)],
            lengths: None,
            seconds: 0.0,
            at: [0.0; 3],
            cut: 0.0,
            rapid: 0.0,
            has_pecks: false,
        }
    }

    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn call(&mut self, draw: &mut Draw, tool: usize) {
        let coolant = ["", "\nM8"][draw.below(2)];
        let speed = 500 + draw.below(8500);
        self.line(&format!("T{tool} M6\nS{speed} M3\nG43 H{tool}{coolant}"));
    }

    /// Retracts, and ends what the tool began.
    fn leave(&mut self, words: &str) {
        let [x, y, _] = self.at;
        self.go([x, y, 60.0], None);
        self.line(&format!("{words}M9\nM5\nG49"));
    }

    fn end(mut self) -> Self {
        self.line("M2");
        self.lengths = (!self.has_pecks).then_some([self.cut, self.rapid]);
        self
    }

    fn near(&self, draw: &mut Draw, most: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis: usize| word(self.at[axis] + draw.within(-most[axis], most[axis])))
    }

    /// Counts a way with feed \[mm, mm/min\].
    fn feed(&mut self, length: f64, feed: f64) {
        self.cut += length;
        self.seconds += 60.0 * length / feed;
    }

    fn go(&mut self, to: [f64; 3], feed: Option<f64>) {
        let [x, y, z] = to;
        let length = distance(self.at, to);
        match feed {
            None => {
                self.line(&format!("G0 X{x} Y{y} Z{z}"));
                self.rapid += length;
            }
            Some(feed) => {
                self.line(&format!("G1 X{x} Y{y} Z{z} F{feed}"));
                self.feed(length, feed);
            }
        }
        self.at = to;
    }

    fn plunge(&mut self, feed: f64) {
        let [x, y, _] = self.at;
        self.go([x, y, 5.0], None);
        self.go([x, y, -2.0], Some(feed));
    }

    fn lines(&mut self, draw: &mut Draw, feed: f64) {
        self.plunge(feed);
        for _ in 0..2 + draw.below(7) {
            let to = self.near(draw, [6.0, 6.0, 1.0]);
            self.go(to, Some(feed));
        }
    }

    /// Arcs up to nearly a turn, whole circles, and helices of both.
    fn arcs(&mut self, draw: &mut Draw, feed: f64) {
        self.plunge(feed);
        for _ in 0..=draw.below(4) {
            let radius = draw.within(2.0, 15.0);
            let start = draw.within(-PI, PI);
            let is_whole = draw.below(5) == 0;
            let size = if is_whole { TAU } else { draw.within(0.3, 6.0) };
            let sweep = if draw.below(2) == 0 { size } else { -size };
            let [x, y, z] = self.at;
            let center = [x - radius * start.cos(), y - radius * start.sin()];
            let on = |angle: f64| {
                [0, 1].map(|axis: usize| {
                    word(center[axis] + radius * [angle.cos(), angle.sin()][axis])
                })
            };
            let [u, v] = if is_whole { [x, y] } else { on(start + sweep) };
            let w = word(z + [0.0, 0.0, -0.5, 0.7][draw.below(4)]);
            let code = if sweep > 0.0 { "G3" } else { "G2" };
            let [i, j] = [center[0] - x, center[1] - y];
            self.line(&format!("{code} X{u} Y{v} Z{w} I{i:.6} J{j:.6} F{feed}"));
            self.feed((radius * sweep).hypot(w - z), feed);
            self.at = [u, v, w];
        }
    }

    /// `G81` or `G85` at some holes.
    fn holes(&mut self, draw: &mut Draw, feed: f64) {
        let [depth, clear] = [draw.within(-8.0, -2.0), draw.within(1.0, 4.0)];
        let (back, is_high) = [("G98", true), ("G99", false)][draw.below(2)];
        let (code, feeds_out) = [("G81", false), ("G85", true)][draw.below(2)];
        let [x, y, _] = self.at;
        self.go([x, y, 20.0], None);
        let above = if is_high { 20.0 } else { clear };
        for hole in 0..=draw.below(4) {
            let to = [draw.within(-30.0, 30.0), draw.within(-30.0, 30.0), self.at[2]];
            let [x, y, z] = to;
            if hole == 0 {
                self.line(&format!("{back} {code} X{x} Y{y} Z{depth} R{clear} F{feed}"));
            } else {
                self.line(&format!("X{x} Y{y}"));
            }
            self.rapid += distance(self.at, to) + z - clear;
            self.feed(clear - depth, feed);
            if feeds_out {
                self.feed(above - depth, feed);
            } else {
                self.rapid += above - depth;
            }
            self.at = [x, y, above];
        }
        self.line("G80");
    }

    /// `G83` or `G73`, whose pecks the control divides.
    fn peck(&mut self, draw: &mut Draw, feed: f64) {
        self.has_pecks = true;
        let [x, y, _] = self.at;
        self.go([x, y, 20.0], None);
        let [depth, clear] = [draw.within(-10.0, -4.0), draw.within(1.0, 4.0)];
        let (code, peck) = (["G83", "G73"][draw.below(2)], draw.within(1.0, 3.0));
        let [x, y] = [word(x + 3.0), word(y - 2.0)];
        self.line(&format!("G98 {code} X{x} Y{y} Z{depth} R{clear} Q{peck} F{feed}\nG80"));
        self.at = [x, y, 20.0];
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis: usize| (b[axis] - a[axis]).powi(2)).sum::<f64>().sqrt()
}
