//! The clock of `LinuxCNC` against times that were measured on it; `fixtures/linuxcnc-times` has their origin.

use trunnion_nc::control::{BlendClock, BlendTolerance, ClockedBlock, ClockedKind};

/// Servo period of the measurements \[s\].
const PERIOD: f64 = 0.001;

fn block(length: f64, velocity: f64) -> ClockedBlock {
    let kind = ClockedKind::Rotary;
    ClockedBlock { length, velocity, acceleration: 5000.0, directions: None, kind }
}

/// Mean number of cycles of one of many equal blocks, start and stop left out.
fn cycles(length: f64, velocity: f64) -> f64 {
    let seconds = |count: u32| {
        let mut clock = BlendClock::new(PERIOD);
        for _ in 0..count {
            clock.push(block(length, velocity), BlendTolerance::Within(0.01));
        }
        clock.stop();
        clock.seconds()
    };
    (seconds(220) - seconds(20)) / (200.0 * PERIOD)
}

#[test]
fn short_blocks_pass_as_measured() {
    // Blocks along X in which A turns, 5000 mm/s², no limit by the feed.
    for (length, measured) in [(0.2, 9.0), (0.5, 14.5), (1.0, 20.0), (2.0, 28.5), (5.0, 45.0)] {
        let found = cycles(length, 500.0);
        assert!((found - measured).abs() < 0.2, "{length} mm: {found}, measured {measured}");
    }
}

#[test]
fn blocks_at_a_feed_pass_as_measured() {
    // Length, feed in mm/min.
    let measured =
        [(0.5, 300.0, 99.0), (0.53, 317.0, 100.0), (0.53, 1111.0, 28.0), (1.37, 1777.0, 46.0)];
    for (length, feed, measured) in measured {
        let found = cycles(length, feed / 60.0);
        assert!((found - measured).abs() < 0.2, "F{feed}: {found}, measured {measured}");
    }
}

/// A single block: up and down the ramps of the full acceleration.
#[test]
fn one_block_takes_its_ramps() {
    let mut clock = BlendClock::new(PERIOD);
    clock.push(block(2.0, 50.0), BlendTolerance::Unbounded);
    clock.stop();
    // 10 ms up, 10 ms down, 0.5 mm together; 1.5 mm at 50 mm/s.
    assert!((clock.seconds() - 0.050).abs() < 0.0021, "{}", clock.seconds());
    clock.wait(2.0);
    clock.stop();
    assert!((clock.seconds() - 2.050).abs() < 0.0021);
}

/// Exact stop takes longer than blending, and a straight path without rotaries runs through.
#[test]
fn the_kind_of_path_decides() {
    let seconds = |block: ClockedBlock, tolerance: BlendTolerance| {
        let mut clock = BlendClock::new(PERIOD);
        (0..100).for_each(|_| clock.push(block, tolerance));
        clock.stop();
        clock.seconds()
    };
    let rotary = block(1.0, 50.0);
    let along = Some([nalgebra::Vector3::x_axis(); 2]);
    let straight = ClockedBlock { kind: ClockedKind::Linear, directions: along, ..rotary };
    let [blended, stopped] =
        [BlendTolerance::Unbounded, BlendTolerance::Stop].map(|of| seconds(rotary, of));
    let through = seconds(straight, BlendTolerance::Unbounded);
    assert!((through - 2.01).abs() < 0.005, "{through}");
    assert!(through <= blended + 0.05 && blended < 0.8 * stopped, "{blended} {stopped}");
    // Blocks that the clock cannot use take no time.
    let nothing = ClockedBlock { length: 0.0, ..rotary };
    assert!(seconds(nothing, BlendTolerance::Unbounded) <= 0.0);
    let endless = ClockedBlock { velocity: f64::NAN, ..rotary };
    assert!(seconds(endless, BlendTolerance::Unbounded) <= 0.0);
}

/// Corners without rotaries: a zigzag with every second leg along X, at F12000; 2500 mm/s² for X and for Y.
#[test]
fn corners_without_rotaries_pass_as_measured() {
    let cycles = |degrees: f64, tolerance: BlendTolerance, length: f64| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let legs = [[1.0, 0.0], [cosine, sine]]
            .map(|[x, y]| nalgebra::Unit::new_normalize(nalgebra::Vector3::new(x, y, 0.0)));
        let seconds = |count: usize| {
            let mut clock = BlendClock::new(PERIOD);
            for k in 0..count {
                let directions = Some([legs[k % 2]; 2]);
                let velocity = 200.0;
                let acceleration = 2500.0 / legs[k % 2].amax();
                let kind = ClockedKind::Linear;
                let block = ClockedBlock { length, velocity, acceleration, directions, kind };
                clock.push(block, tolerance);
            }
            clock.stop();
            clock.seconds()
        };
        (seconds(220) - seconds(20)) / (200.0 * PERIOD)
    };
    let within = BlendTolerance::Within;
    // Degrees, tolerance, length; mean cycles of the four legs in the middle.
    let measured = [
        (20.0, within(0.001), 10.0, 117.5),
        (36.0, within(0.001), 10.0, 117.25),
        (60.0, within(0.01), 10.0, 118.75),
        (90.0, within(0.05), 10.0, 124.25),
        (120.0, within(0.01), 10.0, 122.75),
        (150.0, within(0.001), 10.0, 122.5),
        (60.0, within(0.05), 0.5, 17.5),
        (90.0, within(0.05), 1.0, 36.0),
        (36.0, within(0.01), 0.3, 14.25),
        (36.0, BlendTolerance::Unbounded, 10.0, 53.25),
        (90.0, BlendTolerance::Unbounded, 10.0, 75.5),
        (60.0, BlendTolerance::Unbounded, 1.0, 21.0),
    ];
    for (degrees, tolerance, length, measured) in measured {
        let found = cycles(degrees, tolerance, length);
        // Blocks and arcs end within cycles: a leg of few cycles is off by one and a part.
        assert!(
            (found - measured).abs() < 1.5_f64.max(0.02 * measured),
            "{degrees} degrees, {tolerance:?}, {length} mm: {found}, measured {measured}"
        );
    }
}
