//! Times trunnion's planners on one workload: `trunnion-feed-peers FILE.bin optimal|jerk REPEATS`; or through
//! a window on a path of any number of points that is made as it is run: `trunnion-feed-peers endless
//! optimal|jerk POINTS`, with the memory used at every tenth of them.
//!
//! FILE is little-endian f64: rows, axes, then per row s and five axes with three derivatives, as
//! `workloads.py` writes it. One line of JSON a planner: name, seconds of the schedule, nanoseconds of
//! thread CPU time a point (median), what the dense check found.

use nalgebra::SVector;
use std::error::Error;
use trunnion::feed::{
    FeedOptions, FeedStream, JerkStream, LimitRatios, Limits, StreamOptions, jerk, optimal,
    optimal_schedule,
};
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Motion, Silent};

const COLUMNS: usize = 21;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, method, repeats] = arguments.as_slice() else {
        return Err("FILE.bin optimal|jerk REPEATS".into());
    };
    // All on this thread, whose CPU time is read.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    if file == "endless" {
        return endless(method == "jerk", repeats.parse()?);
    }
    let path = read(file)?;
    let points = path.pieces.iter().map(|piece| piece.nodes.len()).sum::<usize>();
    let run = Run { points: points as f64, repeats: repeats.parse()? };
    let options = |guarantee| FeedOptions {
        time_tolerance: if method == "jerk" { 1e-3 } else { 1.0 },
        guarantee,
        ..FeedOptions::fastest()
    };
    if method == "jerk" {
        run.time("jerk", || {
            let plan = jerk(&path, &limits(true), &options(true), &Silent)?;
            Ok((plan.schedule.duration(), Some(plan.ratios)))
        })?;
        return run.time("jerk, stream of 512", || Ok((streamed_with_jerk(&path)?, None)));
    }
    for (name, guarantee) in [("schedule at rows", false), ("schedule", true)] {
        run.time(name, || {
            let found = optimal_schedule(&path, &limits(false), &options(guarantee), &Silent)?;
            Ok((found.duration(), None))
        })?;
    }
    run.time("optimal", || {
        let plan = optimal(&path, &limits(false), &options(true), &Silent)?;
        Ok((plan.schedule.duration(), Some(plan.ratios)))
    })?;
    run.time("stream of 512", || Ok((streamed(&path)?, None)))
}

struct Run {
    points: f64,
    repeats: u32,
}

impl Run {
    fn time(
        &self,
        name: &str,
        plan: impl Fn() -> Result<(f64, Option<LimitRatios>), Box<dyn Error>>,
    ) -> Result<(), Box<dyn Error>> {
        let mut times = Vec::new();
        let mut last = (0.0, None);
        for _ in 0..self.repeats {
            let start = cpu()?;
            last = plan()?;
            times.push(cpu()? - start);
        }
        times.sort_by(f64::total_cmp);
        let median = times[times.len() / 2] / self.points;
        let ratios =
            last.1.map_or(String::new(), |LimitRatios { velocity, acceleration, jerk, .. }| {
                let jerk = jerk.unwrap_or_default();
                format!(
                    ", \"velocity\": {velocity}, \"acceleration\": {acceleration}, \"jerk\": {jerk}"
                )
            });
        println!("{{\"name\": \"{name}\", \"duration\": {}, \"ns\": {median}{ratios}}}", last.0);
        Ok(())
    }
}

/// CPU time of this thread \[ns\]; yielding makes the kernel bring it up to date.
fn cpu() -> Result<f64, Box<dyn Error>> {
    std::thread::yield_now();
    let text = std::fs::read_to_string("/proc/thread-self/schedstat")?;
    Ok(text.split(' ').next().unwrap_or_default().parse()?)
}

fn read(file: &str) -> Result<AxisPath, Box<dyn Error>> {
    let bytes = std::fs::read(file)?;
    let number = |bytes: &[u8]| bytes.try_into().map(f64::from_le_bytes);
    let numbers = bytes.chunks_exact(8).map(number).collect::<Result<Vec<f64>, _>>()?;
    let rows = numbers.get(2..).unwrap_or_default().chunks_exact(COLUMNS);
    let nodes = rows.map(|row| {
        let axes = |order: usize| SVector::from_iterator(row[1 + 5 * order..].iter().copied());
        let q = std::array::from_fn(axes);
        AxisNode { s: row[0], q, tip_rate: 0.0, feed_rate: 0.0 }
    });
    Ok(AxisPath {
        pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes: nodes.collect() }],
    })
}

fn limits(with_jerk: bool) -> Limits<5> {
    let velocity = SVector::from([500.0, 500.0, 500.0, 6.0, 10.0]);
    Limits {
        velocity,
        rapid: velocity,
        acceleration: SVector::from([5000.0, 5000.0, 5000.0, 60.0, 100.0]),
        jerk: with_jerk.then(|| SVector::from([1e5, 1e5, 1e5, 1200.0, 2000.0])),
        minus: None,
    }
}

fn streamed_with_jerk(path: &AxisPath) -> Result<f64, Box<dyn Error>> {
    let options = StreamOptions::fastest(512, f64::MAX);
    let mut stream = JerkStream::new(limits(true), options)?;
    let mut nodes = path.pieces.iter().flat_map(|piece| &piece.nodes);
    stream.begin(Motion::Cut);
    loop {
        while stream.wants() {
            let Some(node) = nodes.next() else { break };
            stream.push(*node)?;
        }
        if stream.next().is_none() {
            return Ok(stream.time());
        }
    }
}

fn streamed(path: &AxisPath) -> Result<f64, Box<dyn Error>> {
    let options = StreamOptions::fastest(512, f64::MAX);
    let mut stream = FeedStream::new(limits(false), options)?;
    let mut nodes = path.pieces.iter().flat_map(|piece| &piece.nodes);
    stream.begin(Motion::Cut);
    loop {
        while stream.wants() {
            let Some(node) = nodes.next() else { break };
            stream.push(*node)?;
        }
        if stream.next().is_none() {
            return Ok(stream.time());
        }
    }
}

/// Node of a path without end: waves of a few millimetres and tenths of a radian, five points a millimetre.
fn wave(index: u64) -> AxisNode<5> {
    /// Slope, amplitude and waves per millimetre of each axis.
    const AXES: [[f64; 3]; 5] = [
        [0.8, 2.0, 0.031],
        [0.3, 3.0, 0.023],
        [0.0, 1.5, 0.041],
        [0.0, 0.1, 0.017],
        [0.0, 0.15, 0.029],
    ];
    let s = 0.2 * index as f64;
    let q = std::array::from_fn(|order| {
        SVector::from(AXES.map(|[slope, size, waves]| {
            let rate = std::f64::consts::TAU * waves;
            let (sin, cos) = (rate * s).sin_cos();
            let line = [slope * s, slope, 0.0, 0.0][order];
            line + size * rate.powi(order as i32) * [sin, cos, -sin, -cos][order]
        }))
    });
    AxisNode { s, q, tip_rate: 0.0, feed_rate: 0.0 }
}

fn endless(with_jerk: bool, points: u64) -> Result<(), Box<dyn Error>> {
    let options = StreamOptions::fastest(512, f64::MAX);
    let mut fast = FeedStream::new(limits(false), options)?;
    let mut smooth = JerkStream::new(limits(true), options)?;
    fast.begin(Motion::Cut);
    smooth.begin(Motion::Cut);
    let start = cpu()?;
    let mut told = 0;
    for index in 0..points {
        if with_jerk {
            smooth.push(wave(index))?;
            while !smooth.wants() && smooth.next().is_some() {}
        } else {
            fast.push(wave(index))?;
            while !fast.wants() && fast.next().is_some() {}
        }
        if (index + 1) * 10 / points > told {
            told += 1;
            let per_point = (cpu()? - start) / (index + 1) as f64;
            println!("{:>10} points  {per_point:>10.0} ns/pt  {} MiB", index + 1, memory()?);
        }
    }
    let rest = if with_jerk { smooth.by_ref().count() } else { fast.by_ref().count() };
    let time = if with_jerk { smooth.time() } else { fast.time() };
    println!("{time} s of schedule, {rest} stretches after the last point");
    Ok(())
}

/// Largest memory of this process so far \[MiB\].
fn memory() -> Result<f64, Box<dyn Error>> {
    let text = std::fs::read_to_string("/proc/self/status")?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
    Ok((line.trim().trim_end_matches(" kB").parse::<f64>()? / 102.4).round() / 10.0)
}
