//! Tables of setpoints against the machine: no motion that keeps its limits is accused, whatever the decimals and
//! however few columns it is written with; small faults planted in one are found where they are.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::SVector;
use proptest::prelude::*;
use trunnion::files::machine::{built_in, parse};
use trunnion::machine::{AxisKind, Machine};
use trunnion::types::{AXES, AxisVector, Interval};
use trunnion::verify::{
    MotionAudit, MotionError, MotionFinding, MotionOptions, MotionReport, MotionRow,
};

/// Position, velocity, acceleration, jerk.
type State = [f64; 4];

/// A motion of constant jerk piece by piece, `[jerk, time]`.
struct Pieces(Vec<[f64; 2]>);

impl Pieces {
    /// From rest to rest: the pieces, back to no acceleration, and all of that against the velocity reached.
    fn from_rest_to_rest(pieces: &[[f64; 2]]) -> Self {
        let back = pieces.iter().rev().map(|[jerk, t]| [-jerk, *t]);
        let up: Vec<[f64; 2]> = pieces.iter().copied().chain(back).collect();
        let down = up.iter().map(|[jerk, t]| [-jerk, *t]);
        Self(up.iter().copied().chain(down).collect())
    }

    fn duration(&self) -> f64 {
        self.0.iter().map(|[_, t]| t).sum()
    }

    /// Where jerk steps, that which begins.
    fn at(&self, mut t: f64) -> State {
        let mut state = [0.0; 4];
        for &[jerk, length] in &self.0 {
            let t_here = t.min(length);
            state = [state[0], state[1], state[2], jerk];
            let [p, v, a, j] = state;
            let h = t_here;
            state = [
                p + v * h + a * h * h / 2.0 + j * h.powi(3) / 6.0,
                v + a * h + j * h * h / 2.0,
                a + j * h,
                j,
            ];
            t -= length;
            if t < 0.0 {
                break;
            }
        }
        state
    }

    /// Largest velocity, acceleration and jerk: at the ends of pieces, and where acceleration is 0 within one.
    fn most(&self) -> [f64; 3] {
        let (mut most, mut start) = ([0.0_f64; 3], 0.0);
        for &[jerk, length] in &self.0 {
            let a = self.at(start + 1e-12)[2];
            let zero = -a / jerk;
            for t in [0.0, length, zero.clamp(0.0, length)] {
                let [_, v, a, _] = self.at(start + t);
                most = [most[0].max(v.abs()), most[1].max(a.abs()), most[2].max(jerk.abs())];
            }
            start += length;
        }
        most
    }
}

/// Every axis does the same, in its own unit, and its limits are just what it does.
fn machine([velocity, acceleration, jerk]: [f64; 3]) -> Machine {
    let mut machine = parse(built_in("bc-trunnion").unwrap()).unwrap().machine;
    for axis in &mut machine.axes {
        axis.limits = Interval::new(-1e6, 1e6);
        (axis.vel, axis.rapid) = (velocity, velocity);
        (axis.acc, axis.jerk) = (acceleration, jerk);
    }
    machine
}

fn rounded(value: f64, decimals: i32) -> f64 {
    let unit = 10.0_f64.powi(decimals);
    (value * unit).round() / unit
}

/// Rows as a table with these decimals has them: of time, then of position and derivatives.
fn rows(motion: &Pieces, period: f64, decimals: [i32; 5]) -> Vec<MotionRow> {
    let duration = motion.duration();
    let ticks = (0..).map(|k| f64::from(k) * period).take_while(|t| *t < duration - 1e-9);
    let times = ticks.chain([duration]);
    let row = |(line, t): (u32, f64)| {
        let [p, v, a, j] = motion.at(t);
        // At the end the machine stands.
        let state = if t < duration { [p, v, a, j] } else { [p, 0.0, 0.0, j] };
        let values = [0, 1, 2, 3].map(|k| SVector::repeat(rounded(state[k], decimals[k + 1])));
        MotionRow { line, t: rounded(t, decimals[0]), values }
    };
    (3..).zip(times).map(row).collect()
}

fn options(period: f64, derivatives: usize, decimals: [i32; 5]) -> MotionOptions {
    let rounding = |decimals: i32| 0.5 * 10.0_f64.powi(-decimals);
    MotionOptions {
        derivatives,
        time_rounding: rounding(decimals[0]),
        rounding: [1, 2, 3, 4].map(|k| AxisVector::repeat(rounding(decimals[k]))),
        ..MotionOptions::positions(period)
    }
}

fn audit(machine: &Machine, options: &MotionOptions, rows: &[MotionRow]) -> MotionReport {
    let mut audit = MotionAudit::new(machine, options.clone()).unwrap();
    for row in rows {
        audit.push(row).unwrap();
    }
    audit.finish().unwrap()
}

const FINE: [i32; 5] = [9, 10, 7, 4, 1];
const PERIOD: f64 = 0.001;

fn any_pieces() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let piece = ((200.0..5e4f64), any::<bool>(), 2e-4..0.02f64);
    let signed = |(jerk, up, t): (f64, bool, f64)| [if up { jerk } else { -jerk }, t];
    proptest::collection::vec(piece.prop_map(signed), 1..6)
}

proptest! {
    #[test]
    fn no_motion_within_its_limits_is_accused(
        pieces in any_pieces(),
        period in 2e-4..4e-3f64,
        derivatives in 0..4_usize,
        decimals in [5..12i32, 3..12i32, 2..10i32, 1..9i32, 0..6i32],
    ) {
        let motion = Pieces::from_rest_to_rest(&pieces);
        let period = rounded(period, 9);
        let rows = rows(&motion, period, decimals);
        prop_assume!(rows.windows(2).all(|pair| pair[0].t < pair[1].t));
        let machine = machine(motion.most());
        let found = audit(&machine, &options(period, derivatives, decimals), &rows);
        prop_assert!(found.findings.is_empty(), "{:?}", found.findings);
    }

    /// The limit of one axis 0.2 % below what the rows say, in any of the three.
    #[test]
    fn two_per_mille_above_a_limit_are_found(
        pieces in any_pieces(),
        rate in 0..3_usize,
        axis in 0..AXES,
    ) {
        let motion = Pieces::from_rest_to_rest(&pieces);
        let rows = rows(&motion, PERIOD, FINE);
        let largest = rows.iter().map(|row| row.values[rate + 1][0].abs()).fold(0.0, f64::max);
        prop_assume!(largest > [0.01, 10.0, 1000.0][rate]);
        let mut machine = machine(motion.most());
        let low = largest / 1.002;
        let limits = &mut machine.axes[axis];
        match rate {
            0 => (limits.vel, limits.rapid) = (low, low),
            1 => limits.acc = low,
            _ => limits.jerk = low,
        }
        let found = audit(&machine, &options(PERIOD, 3, FINE), &rows);
        let [finding] = &found.findings[..] else { panic!("{:?}", found.findings) };
        let MotionFinding::Rate { axis: name, rate: reported, worst } = finding else {
            panic!("{finding}")
        };
        prop_assert_eq!(name, &machine.axes[axis].name);
        prop_assert_eq!(*reported, ["velocity", "acceleration", "jerk"][rate]);
        prop_assert!(worst.worst > 1.001, "{finding}");
        if rate < 2 {
            // Between rows more can be asked for than any row says.
            let row = rows.iter().find(|row| row.line == worst.line).unwrap();
            let said = row.values[rate + 1][0].abs() / low;
            prop_assert!(worst.between || (said - worst.worst).abs() < 1e-3, "{finding}");
        }
    }

    /// One position off by a micrometre, with derivatives beside it; by 20 without.
    #[test]
    fn a_row_that_was_altered_is_found(
        pieces in any_pieces(),
        share in 0.1..0.9f64,
        (derivatives, by) in prop_oneof![Just((3, 1e-3)), Just((2, 1e-3)), Just((1, 1e-3)), Just((0, 2e-2))],
        axis in 0..AXES,
    ) {
        let motion = Pieces::from_rest_to_rest(&pieces);
        let mut rows = rows(&motion, PERIOD, FINE);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a place in a list")]
        let at = (share * rows.len() as f64) as usize;
        prop_assume!(at + 3 < rows.len());
        let mut most = motion.most();
        most[2] = most[2].max(1e4);
        rows[at].values[0][axis] += by;
        let found = audit(&machine(most), &options(PERIOD, derivatives, FINE), &rows);
        let jerk = |finding: &&MotionFinding| matches!(finding, MotionFinding::Rate { rate: "jerk", .. });
        let finding = found.findings.iter().find(jerk);
        let Some(MotionFinding::Rate { axis: name, worst, .. }) = finding else {
            return Err(TestCaseError::fail(format!("{:?}", found.findings)));
        };
        let machine = machine(most);
        prop_assert_eq!(name, &machine.axes[axis].name);
        prop_assert!(worst.line.abs_diff(rows[at].line) <= 1 && worst.between, "{worst}, planted in {at}");
    }
}

fn example() -> (Machine, Vec<MotionRow>) {
    let motion = Pieces::from_rest_to_rest(&[[30_000.0, 0.0105], [-20_000.0, 0.0041]]);
    (machine(motion.most()), rows(&motion, PERIOD, FINE))
}

#[test]
fn rows_keep_the_period_but_for_the_last() {
    let (machine, mut rows) = example();
    let options = options(PERIOD, 3, FINE);
    let last = rows.windows(2).last().unwrap();
    assert!(last[1].t - last[0].t < 0.9 * PERIOD, "{last:?}");
    assert_eq!(audit(&machine, &options, &rows).findings, []);
    let whole = rows.clone();

    rows.remove(20);
    let found = audit(&machine, &options, &rows).findings;
    let [MotionFinding::Period(uneven)] = &found[..1] else { panic!("{found:?}") };
    assert_eq!((uneven.line, uneven.rows), (24, 1));
    assert!((uneven.step - 2.0 * PERIOD).abs() < 1e-9);

    let short = audit(&machine, &options, &whole[..25]).findings;
    let [MotionFinding::Moving { line: 27, which: "last", .. }, ..] = &short[..] else {
        panic!("{short:?}")
    };

    rows.swap(3, 4);
    let mut audit = MotionAudit::new(&machine, options).unwrap();
    let error = rows.iter().find_map(|row| audit.push(row).err());
    assert!(matches!(error, Some(MotionError::Time { line: 6, .. })), "{error:?}");
}

#[test]
fn travel_is_held() {
    let (mut machine, rows) = example();
    let farthest = rows.iter().map(|row| row.values[0][3]).fold(0.0, f64::max);
    machine.axes[3].limits = Interval::new(-1.0, farthest - 1e-6);
    let found = audit(&machine, &options(PERIOD, 3, FINE), &rows).findings;
    let [MotionFinding::Travel { axis, kind: AxisKind::Rotary, excess, .. }] = &found[..] else {
        panic!("{found:?}")
    };
    assert_eq!(*axis, machine.axes[3].name);
    assert!((excess - 1e-6).abs() < 1e-9);
}

/// Rows that no motion within the jerk limit joins, though each keeps every limit, and so do the differences of
/// neighbours: acceleration up and down again within a period.
#[test]
fn what_happens_between_two_rows_is_found() {
    let (machine, rows) = example();
    let h = PERIOD;
    let jerk = 2.0 * machine.axes[0].jerk;
    // ±jerk by halves of the period: no acceleration is gained, but velocity.
    let swing = |row: &MotionRow, velocity: f64, way: f64| {
        let mut row = *row;
        row.values[1][0] += velocity;
        row.values[0][0] += way;
        row
    };
    let gained = jerk * h * h / 4.0;
    let still = rows[0];
    let after = |k: u32| {
        let t = f64::from(k) * h;
        let moved = swing(&still, gained, gained * h / 2.0 + gained * (t - h));
        MotionRow { t, line: 3 + k, ..moved }
    };
    let mut all = vec![still];
    all.extend((1..4).map(after));
    let back = after(3);
    all.push(MotionRow { t: 4.0 * h, line: 7, ..swing(&back, -gained, gained * h / 2.0) });
    let found = audit(&machine, &options(h, 3, FINE), &all);
    let [MotionFinding::Rate { rate: "jerk", worst, .. }] = &found.findings[..] else {
        panic!("{:?}", found.findings)
    };
    assert!((worst.worst - 2.0).abs() < 0.01 && worst.between, "{worst}");
}
