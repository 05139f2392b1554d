//! A plan through the queue: bounds of the rate, stops, starvation, threads.

use crate::walk::Dice;
use trunnion_rt::motion::{
    LETTERS, MotionPiece, MotionPlayer, MotionSample, PieceError, PieceSender, PlanRate,
    RateBounds, RateError, piece_queue,
};

const PERIOD: f64 = 0.001;
const BOUNDS: RateBounds = RateBounds { change: 8.0, bend: 160.0 };
const DURATION: f64 = 0.003;

/// A motion with rates of all orders: X and A at one plan time \[s\], with their derivatives.
fn path(time: f64) -> [[f64; 3]; 2] {
    let wave = |size: f64, w: f64| {
        let (sin, cos) = (w * time).sin_cos();
        [size * sin, size * w * cos, -size * w * w * sin]
    };
    let [x, a] = [wave(50.0, 1.7), wave(0.8, 2.9)];
    [[x[0] + 30.0 * time, x[1] + 30.0, x[2]], a]
}

/// Quintic through value, velocity and acceleration at both ends.
fn quintic(from: [f64; 3], to: [f64; 3], time: f64) -> [f64; 6] {
    let [p, v, a] = from;
    let d = to[0] - p - v * time - 0.5 * a * time * time;
    let e = to[1] - v - a * time;
    let f = to[2] - a;
    let t3 = time.powi(3);
    [
        p,
        v,
        0.5 * a,
        (10.0 * d - 4.0 * e * time + 0.5 * f * time * time) / t3,
        (-15.0 * d + 7.0 * e * time - f * time * time) / (t3 * time),
        (6.0 * d - 3.0 * e * time + 0.5 * f * time * time) / (t3 * time * time),
    ]
}

/// Piece number `index` of the motion; `rest` where it comes to rest at its end.
fn piece(index: u32) -> MotionPiece {
    let times = [f64::from(index) * DURATION, f64::from(index + 1) * DURATION];
    let [from, to] = times.map(path);
    let mut letters = [[0.0; 6]; LETTERS];
    letters[0] = quintic(from[0], to[0], DURATION);
    letters[3] = quintic(from[1], to[1], DURATION);
    MotionPiece { duration: DURATION, letters, block: index }
}

fn player(pieces: usize) -> (PieceSender, MotionPlayer) {
    let (sender, receiver) = piece_queue(pieces);
    (sender, MotionPlayer::new(receiver, [0.0; LETTERS], BOUNDS, PERIOD).unwrap())
}

/// Sends as many pieces as there is room for, up to `most`; returns the number of the next.
fn fill(sender: &mut PieceSender, mut next: u32, most: u32) -> u32 {
    while next < most {
        match sender.send(&piece(next)) {
            Err(PieceError::QueueFull { .. }) => break,
            sent => {
                sent.unwrap();
                next += 1;
            }
        }
    }
    next
}

/// Watches the rate over cycles: its bounds, and positions on the path.
#[derive(Default)]
struct Watch {
    rates: Vec<f64>,
    /// Positions along X \[mm\].
    x: Vec<f64>,
}

impl Watch {
    fn take(&mut self, sample: MotionSample) {
        assert!((0.0..=1.0).contains(&sample.rate), "{}", sample.rate);
        self.rates.push(sample.rate);
        self.x.push(sample.position[0]);
    }

    /// Every change of the rate, and every change of that, is within its bound, and X keeps the limits that the
    /// bounds promise.
    fn judge(&self) {
        let rate: Vec<f64> = derivative(&self.rates);
        assert!(most(&rate) <= BOUNDS.change * (1.0 + 1e-9), "{}", most(&rate));
        let bend = derivative(&rate);
        assert!(most(&bend) <= BOUNDS.bend * (1.0 + 1e-9), "{}", most(&bend));
        // The largest derivatives of the path by plan time.
        let [q1, q2, q3] = [30.0 + 50.0 * 1.7, 50.0 * 1.7_f64.powi(2), 50.0 * 1.7_f64.powi(3)];
        let RateBounds { change, bend } = BOUNDS;
        let limits =
            [q1, q2 + q1 * change, q3 + 3.0 * q2 * change + q1 * bend].map(|limit| limit * 1.001);
        let mut values = self.x.clone();
        for limit in limits {
            values = derivative(&values);
            assert!(most(&values) <= limit, "{} of {limit}", most(&values));
        }
    }
}

fn derivative(of: &[f64]) -> Vec<f64> {
    of.windows(2).map(|two| (two[1] - two[0]) / PERIOD).collect()
}

fn most(of: &[f64]) -> f64 {
    of.iter().fold(0.0_f64, |most, value| most.max(value.abs()))
}

#[test]
fn a_plan_is_played_as_planned() {
    let (mut sender, mut player) = player(64);
    let mut next = 0;
    let mut time = 0.0;
    let mut before = PlanRate::REST;
    for _ in 0..5000 {
        next = fill(&mut sender, next, u32::MAX);
        let sample = player.cycle(1.0);
        let after = before.toward(1.0, BOUNDS, PERIOD);
        time += before.passed(after, PERIOD);
        before = after;
        let [x, a] = path(time);
        assert!((sample.position[0] - x[0]).abs() < 1e-7, "{time}");
        assert!((sample.position[3] - a[0]).abs() < 1e-9, "{time}");
        assert!((sample.velocity[0] - x[1] * sample.rate).abs() < 1e-4);
        assert!(!sample.starved);
    }
    // Full rate after 1/8 s and the two bends of 1/20 s.
    assert!((time - (5.0 - 0.5 * (0.125 + 0.05))).abs() < 2e-3, "{time}");
}

#[test]
fn an_override_changes_the_rate_within_its_bounds() {
    let (mut sender, mut player) = player(300);
    let mut dice = Dice::new(11);
    let mut watch = Watch::default();
    let (mut next, mut wanted, mut held) = (0, 1.0, 0);
    for cycle in 0..50_000 {
        next = fill(&mut sender, next, u32::MAX);
        if dice.unit() < 0.01 {
            // Now and then a feed hold, full rate, or no number at all.
            wanted = [0.0, 1.0, f64::NAN, dice.unit(), dice.unit()][cycle % 5];
        }
        let sample = player.cycle(wanted);
        held += usize::from(sample.rate <= 0.0);
        assert!(!sample.starved);
        watch.take(sample);
    }
    watch.judge();
    assert!(held > 300, "{held}");
}

#[test]
fn a_late_planner_slows_the_motion_down_and_never_empties_the_queue_at_speed() {
    for seed in 0..8 {
        let (mut sender, mut player) = player(200);
        let mut dice = Dice::new(20 + seed);
        let mut watch = Watch::default();
        let (mut next, mut starved, mut allowed) = (0, 0, 0_u32);
        let mut speed = 0.5;
        for _ in 0..20_000 {
            // The planner sends at a speed that changes, and pauses.
            if dice.unit() < 0.002 {
                speed = [0.0, 0.2, 0.9, 1.5][dice.below(4)];
            }
            allowed += u32::from(dice.unit() < speed * PERIOD / DURATION);
            next = fill(&mut sender, next, allowed);
            let sample = player.cycle(1.0);
            starved += usize::from(sample.starved);
            if sample.ahead <= 1e-9 {
                assert!(sample.rate <= 1e-5, "{} with nothing ahead", sample.rate);
            }
            watch.take(sample);
        }
        watch.judge();
        assert!(starved > 100, "{starved}");
    }
}

#[test]
fn a_stop_from_anywhere_fits_into_its_own_figure() {
    let mut dice = Dice::new(31);
    for _ in 0..2000 {
        let mut at = PlanRate::REST;
        let cycles = dice.below(400);
        let wanted = dice.unit();
        for cycle in 0..cycles {
            at = at.toward(if cycle % 97 < 60 { wanted } else { 0.1 }, BOUNDS, PERIOD);
        }
        let figure = at.stopping_time(BOUNDS, PERIOD);
        let longest = BOUNDS.longest_stop(PERIOD);
        assert!(figure <= longest && longest < 0.3, "{figure}");
        let mut passed = 0.0;
        while !at.is_rest() {
            let next = at.toward(0.0, BOUNDS, PERIOD);
            assert!(next.rate >= 0.0 && next.rate <= 1.0 + 1e-12);
            passed += at.passed(next, PERIOD);
            at = next;
        }
        assert_eq!(passed.to_bits(), figure.to_bits());
    }
}

#[test]
fn a_plan_that_ends_at_rest_is_played_to_its_end() {
    let (mut sender, mut player) = player(8);
    let mut letters = [[0.0; 6]; LETTERS];
    letters[0] = quintic([0.0; 3], [40.0, 0.0, 0.0], 0.5);
    sender.send(&MotionPiece { duration: 0.5, letters, block: 1 }).unwrap();
    let samples: Vec<MotionSample> = (0..700).map(|_| player.cycle(1.0)).collect();
    let end = samples[699];
    assert!((end.position[0] - 40.0).abs() < 1e-9 && end.velocity[0].abs() < 1e-9, "{end:?}");
    assert!(!end.starved);
    // The next plan begins there at once.
    letters[0] = quintic([40.0, 0.0, 0.0], [0.0; 3], 0.5);
    sender.send(&MotionPiece { duration: 0.5, letters, block: 2 }).unwrap();
    let last = (0..505).map(|_| player.cycle(1.0)).last().unwrap();
    assert!(last.position[0].abs() < 1e-9, "{last:?}");
}

#[test]
fn pieces_that_are_no_motion_are_refused() {
    let (mut sender, player) = player(2);
    let good = piece(0);
    assert!(matches!(
        sender.send(&MotionPiece { duration: f64::NAN, ..good }),
        Err(PieceError::Duration { .. })
    ));
    let mut wrong = good;
    wrong.letters[4][2] = f64::INFINITY;
    assert_eq!(sender.send(&wrong), Err(PieceError::NotFinite { block: 0, letter: 4 }));
    sender.send(&good).unwrap();
    assert!(matches!(sender.send(&piece(2)), Err(PieceError::Step { block: 2, letter: 0, .. })));
    sender.send(&piece(1)).unwrap();
    assert_eq!(sender.send(&piece(2)), Err(PieceError::QueueFull { pieces: 2 }));
    drop(player);
}

#[test]
fn bounds_that_a_cycle_cannot_keep_are_refused() {
    let refused = |change: f64, bend: f64, period: f64| {
        let (_, receiver) = piece_queue(1);
        let bounds = RateBounds { change, bend };
        MotionPlayer::new(receiver, [0.0; LETTERS], bounds, period).map(drop).unwrap_err()
    };
    assert!(matches!(
        refused(f64::NAN, 1.0, PERIOD),
        RateError::NotPositive { what: "change", .. }
    ));
    assert!(matches!(refused(1.0, 0.0, PERIOD), RateError::NotPositive { what: "bend", .. }));
    assert!(matches!(refused(1.0, 1.0, -1.0), RateError::NotPositive { what: "servo period", .. }));
    assert!(matches!(refused(1.0, 1e5, PERIOD), RateError::TooFast { .. }));
}

/// Two threads: every piece arrives whole and in its order.
#[test]
fn a_planning_thread_and_a_servo_thread_share_the_queue() {
    const PIECES: u32 = 50_000;
    let (mut sender, receiver) = piece_queue(64);
    let bounds = RateBounds { change: 50.0, bend: 5000.0 };
    let mut servo = MotionPlayer::new(receiver, [0.0; LETTERS], bounds, DURATION).unwrap();
    let planner = std::thread::spawn(move || {
        let mut next = 0;
        while next < PIECES {
            next = fill(&mut sender, next, PIECES);
            std::hint::spin_loop();
        }
    });
    let (mut last, mut jumped) = (None::<MotionSample>, 0_usize);
    loop {
        let sample = servo.cycle(1.0);
        if let Some(last) = last {
            assert!(sample.block >= last.block);
            let step = (sample.position[0] - last.position[0]).abs();
            jumped += usize::from(step > 0.117 * DURATION / PERIOD);
        }
        last = Some(sample);
        if sample.block + 2 >= PIECES {
            break;
        }
    }
    planner.join().unwrap();
    assert_eq!(jumped, 0);
}
