//! `trunnion feed` as a user meets it.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary;

use binary::{stderr, trunnion};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Output;

const LIMITS: &str =
    "[axis.X]\nvel = 50\nacc = 500\njerk = 1e4\n[axis.C]\nvel = 90\nacc = 900\njerk = 2e4\n";

fn folder(path: &str, limits: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("path.csv"), path).unwrap();
    fs::write(folder.path().join("limits.toml"), limits).unwrap();
    folder
}

fn feed(folder: &Path, arguments: &[&str]) -> Output {
    let start = ["feed", "path.csv", "--limits", "limits.toml"];
    trunnion(folder, &[&start[..], arguments].concat())
}

/// X goes straight, C as a sine; `ends` are the rows.
fn table(rows: &[f64]) -> String {
    let mut text = "s,X,X1,X2,X3,C,C1,C2,C3\n".to_owned();
    for s in rows {
        let (sin, cos) = (0.1 * s).sin_cos();
        let c = [sin, 0.1 * cos, -0.01 * sin, -0.001 * cos].map(|value| 20.0 * value);
        writeln!(text, "{s},{s},1,0,0,{},{},{},{}", c[0], c[1], c[2], c[3]).unwrap();
    }
    text
}

fn even(rows: u32, step: f64) -> Vec<f64> {
    (0..rows).map(|k| f64::from(k) * step).collect()
}

fn summary(folder: &Path, arguments: &[&str]) -> Value {
    let all: Vec<&str> = arguments.iter().copied().chain(["--json", "-o", "out.csv"]).collect();
    let output = feed(folder, &all);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn rows(text: &str) -> Vec<Vec<f64>> {
    let row = |line: &str| line.split(',').map(|field| field.parse().unwrap()).collect();
    text.lines().skip(1).map(row).collect()
}

#[test]
fn a_schedule_keeps_its_limits_and_lands_on_the_end() {
    let folder = folder(&table(&even(201, 0.5)), LIMITS);
    for method in ["jerk", "optimal"] {
        let found = summary(
            folder.path(),
            &["--method", method, "--motion", "motion.csv", "--period", "0.01"],
        );
        let number = |name: &str| found[name].as_f64().unwrap();
        // 100 mm at 50 mm/s, and some time for starting and stopping.
        assert!(number("duration") > 2.0 && number("duration") < 2.4, "{found}");
        assert!(number("lower_bound") <= number("duration"));
        assert!(found["bounds"]["acceleration"].as_f64().unwrap() <= 1.0 + 1e-12);
        assert!(found["ratios"]["velocity"].as_f64().unwrap() > 0.99);
        let schedule = rows(&fs::read_to_string(folder.path().join("out.csv")).unwrap());
        assert_eq!(schedule.len() as u64, found["points"].as_u64().unwrap());
        let last = schedule.last().unwrap();
        assert!((last[0] - 100.0).abs() < 1e-12 && last[2].abs() < 1e-9);
        assert!((last[1] - number("duration")).abs() < 1e-12);
        // The motion, from differences alone.
        let motion = rows(&fs::read_to_string(folder.path().join("motion.csv")).unwrap());
        assert!((motion.last().unwrap()[1] - 100.0).abs() < 1e-12);
        for pair in motion.windows(2) {
            let dt = pair[1][0] - pair[0][0];
            let [x, c] = [1, 2].map(|axis| ((pair[1][axis] - pair[0][axis]) / dt).abs());
            assert!(x <= 50.0 * (1.0 + 1e-6) && c <= 90.0 * (1.0 + 1e-6), "{x} {c}");
        }
    }
}

/// Where rows are inserted close together, bounds of 1 are met but for rounding: that is no breach. By
/// rows alone the same path breaks its limits, and that is reported.
#[test]
fn rounding_is_no_breach_and_a_breach_is_reported() {
    let mut text = "s,X,X1,X2,X3,C,C1,C2,C3\n".to_owned();
    for k in 0..=400 {
        let s = 0.25 * f64::from(k);
        let wave = |size: f64, w: f64| {
            let (sin, cos) = (w * s).sin_cos();
            [sin, w * cos, -w * w * sin, -w.powi(3) * cos].map(|value| size * value)
        };
        let [x, c] = [wave(10.0, 0.5), wave(20.0, 0.31)];
        let row: Vec<String> = x.iter().chain(&c).map(f64::to_string).collect();
        writeln!(text, "{s},{}", row.join(",")).unwrap();
    }
    let folder = folder(&text, LIMITS);
    let found = summary(folder.path(), &["--method", "optimal"]);
    assert_eq!(found["within_limits"], true);
    assert!(found["inserted"].as_u64().unwrap() > 0);
    let output = feed(folder.path(), &["--method", "optimal", "--no-guarantee", "-o", "rows.csv"]);
    assert_eq!(output.status.code(), Some(1));
    let reported = String::from_utf8_lossy(&output.stdout);
    assert!(reported.contains("a limit is broken between rows"), "{reported}");
}

#[test]
fn limits_along_the_path_and_speeds_at_its_ends() {
    let path = "[path]\nfeed = 20\nacc = 100\nstart = 10\nend = 5\n";
    let folder = folder(&table(&even(201, 0.5)), &format!("{LIMITS}{path}"));
    let found = summary(folder.path(), &["--method", "optimal", "--time-tolerance", "1e-7"]);
    // 10 to 20 and 20 to 5 at 100: 0.1 s over 1.5, 0.15 s over 1.875; the rest at 20.
    let want = 0.1 + 0.15 + (100.0 - 1.5 - 1.875) / 20.0;
    let got = found["duration"].as_f64().unwrap();
    assert!((got / want - 1.0).abs() < 1e-6, "{got} {want}");
    let schedule = rows(&fs::read_to_string(folder.path().join("out.csv")).unwrap());
    assert!((schedule[0][2] - 10.0).abs() < 1e-9);
    assert!((schedule.last().unwrap()[2] - 5.0).abs() < 1e-9);
    // With jerk limits as well, in hardly more time.
    let found = summary(folder.path(), &[]);
    let jerk = found["duration"].as_f64().unwrap();
    assert!(jerk > want && jerk < 1.05 * want, "{jerk} {want}");
    let schedule = rows(&fs::read_to_string(folder.path().join("out.csv")).unwrap());
    assert!((schedule[0][2] - 10.0).abs() < 1e-9);
    assert!((schedule.last().unwrap()[2] - 5.0).abs() < 1e-9);
    // 100 mm are not enough to stop from 20 mm/s with 1 mm/s².
    let path = "[path]\nacc = 1\nstart = 20\n";
    fs::write(folder.path().join("limits.toml"), format!("{LIMITS}{path}")).unwrap();
    let output = feed(folder.path(), &[]);
    assert_eq!(output.status.code(), Some(2));
    let reported = stderr(&output);
    assert!(reported.contains("start speed 20 is above what the path allows"), "{reported}");
}

#[test]
fn a_feed_column_limits_every_row() {
    let text: String = table(&even(101, 1.0))
        .lines()
        .enumerate()
        .map(|(k, line)| match k {
            0 => format!("{line},feed\n"),
            40..60 => format!("{line},5\n"),
            _ => format!("{line},40\n"),
        })
        .collect();
    let folder = folder(&text, LIMITS);
    summary(folder.path(), &["--method", "optimal"]);
    for row in rows(&fs::read_to_string(folder.path().join("out.csv")).unwrap()) {
        let most = if (39.0..=58.0).contains(&row[0]) { 5.0 } else { 40.0 };
        assert!(row[2] <= most * (1.0 + 1e-9), "{row:?}");
    }
}

#[test]
fn a_jump_of_the_direction_is_a_rest_and_is_reported() {
    let text = "s,X,X1,X2\n0,0,1,0\n10,10,1,0\n10,10,-1,0\n20,0,-1,0\n";
    let folder = folder(text, "[axis.X]\nvel = 50\nacc = 500\njerk = 1e4\n");
    let output = feed(folder.path(), &["--json", "-o", "out.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("line 4: the axes rest at s = 10, where X1 jumps by -2"));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["rests"], 1);
    for row in rows(&fs::read_to_string(folder.path().join("out.csv")).unwrap()) {
        assert!((row[0] - 10.0).abs() > 1e-12 || row[2].abs() < 1e-12, "{row:?}");
    }
}

/// Exit 2, the message, and no file.
fn refused(text: &str, limits: &str, arguments: &[&str], needle: &str) {
    let folder = folder(text, limits);
    let all: Vec<&str> = arguments.iter().copied().chain(["-o", "out.csv"]).collect();
    let output = feed(folder.path(), &all);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains(needle), "{needle:?} is not in:\n{message}");
    assert!(!folder.path().join("out.csv").exists());
}

#[test]
fn wrong_tables_are_named_with_row_and_axis() {
    let good = table(&even(11, 1.0));
    let with = |from: &str, to: &str| good.replacen(from, to, 1);
    refused(
        &with("\n3,3,", "\n1.5,3,"),
        LIMITS,
        &[],
        "path.csv:5: s = 1.5 is below 2 of the row before",
    );
    refused(&with("\n3,3,", "\n3,nan,"), LIMITS, &[], "path.csv:5:3: X = nan is not a finite");
    refused(
        &with("\n3,3,1,0,0,", "\n3,3,1,0,7,"),
        LIMITS,
        &[],
        "path.csv:5: X3 = 7, but the quintic",
    );
    refused(
        &with("\n3,3,", "\n2,9,"),
        LIMITS,
        &[],
        "path.csv:5: X jumps by 7 from 2 to 9 at s = 2",
    );
    refused(&with("\n1,1,", "\n0,0,"), LIMITS, &[], "path.csv:3: s = 0 is repeated once too often");
    refused(&with("X2", "Y2"), LIMITS, &[], "column X2 is missing");
    refused("s,X,X1,X2\n0,0,1,0\n", "[axis.X]\nvel=1\nacc=1\njerk=1\n", &[], "at least two rows");
    refused("", LIMITS, &[], "the table is empty");
}

#[test]
fn wrong_limits_are_named_with_what_to_do() {
    let good = table(&even(11, 1.0));
    let one = "[axis.X]\nvel = 50\nacc = 500\n";
    refused(&good, &format!("{one}jerk = 1\n"), &[], "axis C has no limits\n  help: add [axis.C]");
    refused(&good, &LIMITS.replace("jerk = 1e4\n", ""), &[], "axis X has no jerk limit");
    refused(
        &good,
        &LIMITS.replace("acc = 500", "acc = 0"),
        &[],
        "limits.toml:3:7: `axis.X.acc` = 0",
    );
    refused(&good, &LIMITS.replace("acc = 500", ""), &[], "missing key `acc` in [axis.X]");
    let fast = format!("{LIMITS}[path]\nstart = 60\n");
    let optimal = ["--method", "optimal"];
    refused(&good, &fast, &optimal, "start speed 60 is above what the path allows, ");
    refused(&good, LIMITS, &["--no-guarantee"], "goes with --method optimal");
}

#[test]
fn a_window_gives_the_schedule_of_the_whole_path() {
    let folder = folder(&table(&even(201, 0.5)), LIMITS);
    let optimal = ["--method", "optimal", "--time-tolerance", "1"];
    let whole = summary(folder.path(), &optimal);
    let window = summary(folder.path(), &["--method", "optimal", "--window", "64"]);
    let [whole, through] = [&whole, &window].map(|found| found["duration"].as_f64().unwrap());
    assert!(through >= whole * (1.0 - 1e-9) && through <= whole * 1.001, "{through} {whole}");
    assert_eq!(window["window"], 64);
    let last = rows(&fs::read_to_string(folder.path().join("out.csv")).unwrap()).pop().unwrap();
    assert!((last[0] - 100.0).abs() < 1e-12 && last[2].abs() < 1e-9);
    let blocks = ["--method", "blocks", "--window", "64"];
    refused(&table(&even(9, 1.0)), LIMITS, &blocks, "goes with --method optimal or jerk");
    let moving = format!("{LIMITS}[path]\nend = 5\n");
    refused(&table(&even(9, 1.0)), &moving, &["--window", "64"], "starts and ends at rest");
}

/// 1e-6 between setpoints 1 ms apart: 8 mm/s² at most.
#[test]
fn a_chord_error_limits_acceleration() {
    let limits = LIMITS.replacen("acc", "chord = 1e-6\nacc", 1);
    let folder = folder(&table(&even(101, 1.0)), &limits);
    let reported = summary(folder.path(), &["--method", "optimal", "--motion", "motion.csv"]);
    assert_eq!(reported["binding"][0]["limit"], "chord error of X");
    let motion = rows(&fs::read_to_string(folder.path().join("motion.csv")).unwrap());
    let width = (motion[0].len() - 1) / 4;
    let most = motion.iter().map(|row| row[1 + 2 * width].abs()).fold(0.0, f64::max);
    assert!(most <= 8.0 * (1.0 + 1e-9) && most > 7.9, "{most}");
}

/// Without its feature, Parquet is refused with a remedy; with it, the file begins and ends as such files do.
#[test]
fn parquet_is_a_feature() {
    let table = table(&even(9, 1.0));
    if !cfg!(feature = "parquet") {
        refused(&table, LIMITS, &["--motion", "motion.parquet"], "--features parquet");
        return;
    }
    let folder = folder(&table, LIMITS);
    summary(folder.path(), &["--motion", "motion.parquet"]);
    let bytes = fs::read(folder.path().join("motion.parquet")).unwrap();
    assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
}

/// 100 along a straight line towards plus: a lower limit towards minus is felt where X slows down.
#[test]
fn directions_may_differ() {
    let time = |limits: &str| {
        let folder = folder(&table(&even(101, 1.0)), limits);
        let reported = summary(folder.path(), &["--method", "optimal"]);
        assert!(reported["bounds"]["acceleration"].as_f64().unwrap() <= 1.0 + 1e-9);
        reported["duration"].as_f64().unwrap()
    };
    let slower = LIMITS.replacen("acc = 500", "acc = 500\nacc_minus = 50", 1);
    assert!(time(&slower) > 1.05 * time(LIMITS));
    let wrong = LIMITS.replacen("acc = 500", "acc = 500\nacc_minus = -50", 1);
    refused(&table(&even(9, 1.0)), &wrong, &[], "`axis.X.acc_minus` = -50 must be above 0");
}

#[test]
fn a_window_keeps_jerk_limits_too() {
    let folder = folder(&table(&even(201, 0.5)), LIMITS);
    let whole = summary(folder.path(), &[]);
    let window = summary(folder.path(), &["--window", "64"]);
    let [longest, through] = [&whole, &window].map(|found| found["duration"].as_f64().unwrap());
    assert!(through <= longest * 1.002, "{through} {longest}");
    for kind in ["velocity", "acceleration", "jerk"] {
        let [ratio, bound] = ["ratios", "bounds"].map(|name| window[name][kind].as_f64().unwrap());
        assert!(ratio <= bound + 1e-9 && bound <= 1.0 + 1e-9, "{kind}: {ratio} {bound}");
        assert!(bound > 0.0);
    }
    assert_eq!(window["lower_bound"], whole["lower_bound"]);
    let last = rows(&fs::read_to_string(folder.path().join("out.csv")).unwrap()).pop().unwrap();
    assert!((last[0] - 100.0).abs() < 1e-12 && last[2].abs() < 1e-9);
}

#[test]
fn classical_blocks_are_reported_what_they_break() {
    let folder = folder(&table(&even(101, 1.0)), LIMITS);
    let output = feed(folder.path(), &["--method", "blocks", "--json", "-o", "out.csv"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let within = found["within_limits"].as_bool().unwrap();
    assert_eq!(output.status.code(), Some(i32::from(!within)), "{}", stderr(&output));
    assert_eq!(found["method"], "blocks");
    assert!(found["duration"].as_f64().unwrap() > 2.0, "{found}");
}

/// 10 mm at constant 20 mm/s is 0.5 s; a step to rest at the end would break the acceleration.
#[test]
fn given_speeds_are_run_and_their_breaches_reported() {
    let text = "s,X,X1,X2,speed\n0,0,1,0,20\n5,5,1,0,20\n10,10,1,0,20\n";
    let limits = "[axis.X]\nvel = 50\nacc = 500\njerk = 1e4\n";
    let kept = folder(text, limits);
    let found = summary(kept.path(), &["--method", "given"]);
    assert!((found["duration"].as_f64().unwrap() - 0.5).abs() < 1e-12, "{found}");
    let fast = folder(&text.replace("5,5,1,0,20", "5,5,1,0,80"), limits);
    let output = feed(fast.path(), &["--method", "given", "-o", "out.csv"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    // 80² - 20² over 2 x 5 mm: 600 mm/s², and 80 of 50 mm/s.
    assert!(
        stderr(&output).contains("acceleration of X is 1.2000 of its limit"),
        "{}",
        stderr(&output)
    );
    assert!(stderr(&output).contains("velocity of X is 1.6000 of its limit at s = 5"));
    let bare = text.replace(",speed", "").replace(",20\n", "\n");
    refused(&bare, limits, &["--method", "given"], "column speed is missing");
    let stopped = text.replace(",20\n", ",0\n");
    refused(&stopped, limits, &["--method", "given"], "the given speed is zero from s = 0 to 5");
    let wrong = text.replace("5,5,1,0,20", "5,5,1,0,-3");
    refused(&wrong, limits, &["--method", "given"], "speeds be finite and not negative");
}

/// Row by row, the schedule is that of the whole table through the same window; faults are reported as they are there.
#[test]
fn a_streamed_table_gives_the_schedule_of_its_window() {
    // Two pieces: the sine is left for a straight line in both axes.
    let mut text = table(&even(201, 0.5));
    let (sin, _) = (0.1_f64 * 100.0).sin_cos();
    for k in 0..40_u32 {
        let s = 100.0 + f64::from(k);
        writeln!(text, "{s},{s},1,0,0,{},0.25,0,0", 20.0 * sin + 0.25 * f64::from(k)).unwrap();
    }
    let folder = folder(&text, LIMITS);
    for method in ["jerk", "optimal"] {
        let window = ["--method", method, "--window", "64"];
        let whole = summary(folder.path(), &window);
        let read = |name: &str| rows(&fs::read_to_string(folder.path().join(name)).unwrap());
        let expected = read("out.csv");
        let found = summary(folder.path(), &[&window[..], &["--stream"]].concat());
        let got = read("out.csv");
        assert_eq!(got.len(), expected.len(), "{method}");
        assert_eq!(found["points"].as_u64().unwrap(), got.len() as u64);
        assert_eq!([&found["read"], &found["rests"]], [241, 1]);
        for (got, expected) in got.iter().zip(&expected) {
            for (column, (got, expected)) in
                got.iter().zip(expected).enumerate().take(if method == "jerk" { 4 } else { 3 })
            {
                let off = (got - expected).abs();
                assert!(
                    off <= 1e-9 * expected.abs().max(1.0),
                    "{method} {column}: {got} {expected}"
                );
            }
        }
        let [long, short] = [&whole, &found].map(|reported| reported["duration"].as_f64().unwrap());
        assert!((long - short).abs() <= 1e-9 * long, "{method}: {long} {short}");
    }
    let stream = ["--window", "64", "--stream"];
    refused(&text.replace("103,103,", "102,102,"), LIMITS, &stream, "C jumps by 0.25");
    refused(
        &text.replace("105,105,1,", "105,105,0.5,"),
        LIMITS,
        &stream,
        "but the quintic through",
    );
    refused(&table(&[0.0]), LIMITS, &stream, "at least two rows");
    refused(&table(&[0.0, 1.0, 1.0]), LIMITS, &stream, "once too often");
    refused(&text, LIMITS, &["--stream"], "--window");
    let args = ["feed", "-", "--limits", "limits.toml", "--window", "64", "--stream"];
    assert!(stderr(&trunnion(folder.path(), &args)).contains("name a file"));
}
