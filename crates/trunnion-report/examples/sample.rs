//! Writes a page with made-up but plausible data to stdout: for work on the viewer.
//!
//! `cargo run -p trunnion-report --example sample > sample.html`

use std::error::Error;
use std::f64::consts::TAU;
use std::io::Write;
use trunnion_report::{
    Axis, Budget, Check, Histogram, MotionKind, Number, PathPiece, PathPoint, Recorder, ReportData,
    Sample, Share, State, Surface, SurfacePoint, WorstPlace, render,
};

const SIZE: f64 = 100.0;
const PASSES: usize = 12;
const SAMPLES: usize = 40_000;
const DURATION: f64 = 42.0;

fn height(x: f64, y: f64) -> f64 {
    let [u, v] = [x / SIZE, y / SIZE];
    18.0 * (0.9 * TAU * u * 0.5).sin() * (1.0 - v) + 14.0 * v * v - 6.0 * (TAU * 0.5 * v).sin() * u
}

fn deviation(x: f64, y: f64) -> Option<f64> {
    if x > 96.5 && y > 97.0 {
        return None;
    }
    let strip = SIZE / PASSES as f64;
    let across = (x / strip).fract() - 0.5;
    let scallop = 0.017 * (2.0 * across).powi(2) + 0.001 * (0.7 * y).sin();
    let dent = 0.006 * (-((x - 30.0).powi(2) + (y - 62.0).powi(2)) / 9.0).exp();
    Some(scallop - dent - 0.0006 + 0.004 * (x / SIZE).powi(6))
}

fn surface() -> Surface {
    let columns = 420;
    let points: Vec<_> = (0..columns * columns)
        .map(|at| {
            let [x, y] =
                [at % columns, at / columns].map(|k| SIZE * k as f64 / (columns - 1) as f64);
            Some(SurfacePoint { position: [x, y, height(x, y)], deviation: deviation(x, y) })
        })
        .collect();
    let mut surface = Surface::default();
    surface.add_grid(columns, &points);
    surface
}

fn pose(t: f64) -> (PathPoint, MotionKind) {
    let share = (t / DURATION * PASSES as f64).min(PASSES as f64 - 1e-9);
    let (pass, along) = (share.floor(), share.fract());
    let x = (pass + 0.5) * SIZE / PASSES as f64;
    let back = pass.rem_euclid(2.0) > 0.5;
    let (motion, progress, lift) = match along {
        a if a < 0.06 => (MotionKind::LeadIn, 0.0, 50.0 * (1.0 - a / 0.06)),
        a if a > 0.97 => (MotionKind::Link, 1.0, 50.0),
        a if a > 0.92 => (MotionKind::LeadOut, 1.0, 50.0 * (a - 0.92) / 0.05),
        a => (MotionKind::Cut, (a - 0.06) / 0.86, 0.0),
    };
    let y = SIZE * if back { 1.0 - progress } else { progress };
    let contact = [x, y, height(x, y)];
    let step = 1e-3;
    let slope = [
        (height(x + step, y) - height(x, y)) / step,
        (height(x, y + step) - height(x, y)) / step + if back { 0.22 } else { -0.22 },
    ];
    let length = (1.0 + slope[0].powi(2) + slope[1].powi(2)).sqrt();
    let axis = [-slope[0] / length, -slope[1] / length, 1.0 / length];
    let tip = [0, 1, 2].map(|k| contact[k] + (lift + 0.8) * axis[k]);
    (PathPoint { t, tip, axis, contact }, motion)
}

fn axes_at(t: f64) -> [f64; 5] {
    let (PathPoint { tip, axis, .. }, _) = pose(t);
    let tilt = axis[2].acos().to_degrees();
    let turn = axis[1].atan2(axis[0]).to_degrees();
    [tip[0], tip[1], tip[2] - 300.0, turn, tilt]
}

fn axis(name: &str, unit: &str, travel: Option<[f64; 2]>, limits: [f64; 3]) -> Axis {
    let [velocity, acceleration, jerk] = limits;
    Axis {
        name: name.into(),
        unit: unit.into(),
        travel,
        velocity,
        acceleration,
        chord: false,
        jerk,
    }
}

fn record() -> trunnion_report::Motion {
    let axes = vec![
        axis("X", "mm", Some([-400.0, 400.0]), [500.0, 2500.0, 30000.0]),
        axis("Y", "mm", Some([-400.0, 400.0]), [500.0, 2500.0, 30000.0]),
        axis("Z", "mm", Some([-500.0, 0.0]), [500.0, 2500.0, 30000.0]),
        axis("C", "deg", None, [300.0, 2600.0, 20000.0]),
        axis("B", "deg", Some([-35.0, 120.0]), [150.0, 1300.0, 20000.0]),
    ];
    let mut recorder = Recorder::new(axes, DURATION, 3000, 50.0);
    let step = DURATION / SAMPLES as f64;
    for k in 0..=SAMPLES {
        let t = k as f64 * step;
        let h = 0.02;
        let [before, now, after] = [axes_at(t - h), axes_at(t), axes_at(t + h)];
        let velocity: Vec<f64> = (0..5).map(|a| (after[a] - before[a]) / (2.0 * h)).collect();
        let acceleration: Vec<f64> =
            (0..5).map(|a| (after[a] - 2.0 * now[a] + before[a]) / (h * h)).collect();
        let cutting = pose(t).1 == MotionKind::Cut;
        let speed = if cutting { 50.0 - 20.0 * (0.9 * t).sin().powi(8) } else { 80.0 };
        recorder.add(&Sample {
            t,
            position: &now,
            velocity: &velocity.iter().map(|v| v.clamp(-500.0, 500.0)).collect::<Vec<_>>(),
            acceleration: &acceleration
                .iter()
                .map(|a| a.clamp(-2500.0, 2500.0))
                .collect::<Vec<_>>(),
            jerk: &[0.0; 5],
            speed,
            tip: speed,
            cutting,
        });
    }
    recorder.finish()
}

fn path() -> Vec<PathPiece> {
    let mut pieces: Vec<PathPiece> = Vec::new();
    for k in 0..=8000 {
        let (point, motion) = pose(DURATION * f64::from(k) / 8000.0);
        match pieces.last_mut() {
            Some(piece) if piece.motion == motion => piece.points.push(point),
            _ => {
                let joint = pieces.last().and_then(|piece| piece.points.last().copied());
                let points = joint.into_iter().chain([point]).collect();
                pieces.push(PathPiece { motion, tool: 0, points });
            }
        }
    }
    pieces
}

fn number(label: &str, value: &str, unit: &str, note: &str, state: State) -> Number {
    let headline = !matches!(label, "Stations" | "Cutting length" | "Lower bound of time");
    let [label, value, unit, note] = [label, value, unit, note].map(str::to_owned);
    Number { label, value, unit, note, state, headline }
}

fn numbers() -> Vec<Number> {
    vec![
        number("Deepest gouge", "6.3", "µm", "allowed 2.0 µm", State::Bad),
        number("Most material left", "19.4", "µm", "allowed 20.0 µm", State::Good),
        number("Not cut", "180", "points", "of 176 400", State::Bad),
        number("Planned time", "42.0", "s", "98.9 % of the best possible", State::Plain),
        number("Passes", "12", "", "mean strip 8.3 mm", State::Plain),
        number("Worst axis load", "99.9", "%", "C acceleration", State::Good),
        number("Cutting length", "1231", "mm", "", State::Plain),
        number("Stations", "8001", "", "", State::Plain),
        number("Lower bound of time", "41.5", "s", "", State::Plain),
    ]
}

fn budget() -> Budget {
    let share = |name: &str, allowed, used| Share { name: name.into(), allowed, used };
    Budget {
        total: 0.02,
        gouge: 0.002,
        shares: vec![
            share("Strips", 0.0165, Some(0.0163)),
            share("Curves through cutter locations", 0.001, Some(0.0004)),
            share("Blocks of the program", 0.001, Some(0.0009)),
            share("Decimals", 0.0005, None),
            share("Smoothing by the control", 0.001, None),
        ],
    }
}

fn tool_outline() -> Vec<[f64; 2]> {
    (0..=12)
        .map(|k| {
            let angle = f64::from(k) / 12.0 * TAU / 4.0;
            [10.0 + 6.0 * angle.sin(), 6.0 - 6.0 * angle.cos()]
        })
        .fold(vec![[0.0, 0.0]], |mut outline, point| {
            outline.push(point);
            outline
        })
        .into_iter()
        .chain([[16.0, 40.0], [10.0, 40.0], [10.0, 75.0], [25.0, 75.0], [25.0, 110.0]])
        .collect()
}

fn check(deviations: &[f64]) -> Check {
    let place = |kind: &str, point, deviation, note: &str| WorstPlace {
        kind: kind.into(),
        point,
        deviation,
        note: note.into(),
    };
    Check {
        method: "program.linuxcnc.ngc was read back and replayed; 176 400 points, 0.24 mm apart, \
                     between them at most 0.2 µm more."
            .into(),
        grid: 0.24,
        points: 176_400,
        uncut: 180,
        histogram: Histogram::of(deviations.iter().copied(), [-0.008, 0.024], 64),
        places: vec![
            place("gouge", [30.0, 62.0, height(30.0, 62.0)], Some(-0.0063), "line 2213, pass 4"),
            place("not cut", [98.0, 99.0, height(98.0, 99.0)], None, "corner of face 0"),
            place("excess", [91.7, 20.0, height(91.7, 20.0)], Some(0.0194), "passes 10 and 11"),
        ],
    }
}

fn data() -> ReportData {
    let surface = surface();
    let deviations: Vec<f64> = surface.deviation.iter().flatten().copied().collect();
    ReportData {
        job: "sample <wave> & co".into(),
        part: "wave.json, face 0".into(),
        machine: "bc-trunnion, C on B table; origin 0, 0, -300 mm, turned 0°, 20°, 0°".into(),
        tool: "T1 bull-nose R 10 mm, r 6 mm, length 120 mm".into(),
        generator: concat!("trunnion ", env!("CARGO_PKG_VERSION")).into(),
        passed: false,
        verdict: vec![
            "the part is gouged by 6.3 µm where 2.0 µm are allowed".into(),
            "180 points are not cut".into(),
        ],
        warnings: vec!["C turns 12°/mm near v = 0.9: the feed drops to 38 % there.".into()],
        numbers: numbers(),
        budget: budget(),
        tools: vec![tool_outline()],
        path: path(),
        motion: record(),
        check: check(&deviations),
        stock: None,
        fixtures: None,
        smoothing: String::new(),
        surface,
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    Ok(std::io::stdout().lock().write_all(render(&data())?.as_bytes())?)
}
