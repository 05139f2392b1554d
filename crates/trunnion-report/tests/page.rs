//! The page as a text: nothing is loaded from anywhere, nothing in a name can break out of it.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use std::fs;
use std::path::Path;
use trunnion_report::{
    Axis, Budget, MotionKind, Number, PathPiece, PathPoint, Recorder, ReportData, Sample, Surface,
    SurfacePoint, WorstPlace, render,
};

const HOSTILE: &str = "</script><img src=x onerror=alert(1)>\u{2028}\"'&";

fn hostile() -> ReportData {
    let point = |t| PathPoint { t, tip: [t; 3], axis: [0.0, 0.0, 1.0], contact: [t; 3] };
    let mut surface = Surface::default();
    let measured =
        |x: f64| Some(SurfacePoint { position: [x, x * x, 0.0], deviation: Some(0.001 * x) });
    surface.add_grid(2, &[0.0, 1.0, 2.0, 3.0].map(measured));
    let axis = Axis {
        name: HOSTILE.into(),
        velocity: 1.0,
        acceleration: 1.0,
        jerk: 1.0,
        ..Axis::default()
    };
    let mut recorder = Recorder::new(vec![axis], 1.0, 10, 1.0);
    let [position, velocity, acceleration] = [[0.5], [f64::NAN], [f64::INFINITY]];
    let jerk = [f64::NEG_INFINITY];
    recorder.add(&Sample {
        t: 0.5,
        position: &position,
        velocity: &velocity,
        acceleration: &acceleration,
        jerk: &jerk,
        tip: f64::NAN,
        speed: 1.0,
        cutting: true,
    });
    let mut data = ReportData {
        job: HOSTILE.into(),
        part: HOSTILE.into(),
        machine: HOSTILE.into(),
        tool: HOSTILE.into(),
        generator: HOSTILE.into(),
        verdict: vec![HOSTILE.into()],
        warnings: vec![HOSTILE.into()],
        numbers: vec![Number {
            label: HOSTILE.into(),
            value: HOSTILE.into(),
            headline: true,
            ..Number::default()
        }],
        budget: Budget { total: 0.02, gouge: 0.002, shares: Vec::new() },
        surface,
        path: vec![PathPiece {
            motion: MotionKind::Cut,
            tool: 0,
            points: vec![point(0.0), point(1.0)],
        }],
        motion: recorder.finish(),
        ..ReportData::default()
    };
    data.check.method = HOSTILE.into();
    data.check.places = vec![WorstPlace {
        kind: HOSTILE.into(),
        point: [f64::NAN; 3],
        deviation: Some(f64::INFINITY),
        note: HOSTILE.into(),
    }];
    data
}

/// The page without its script, and the text of its data element.
fn parts(page: &str) -> (String, &str) {
    let (before, rest) = page.split_once("<script type=\"application/json\" id=\"data\">").unwrap();
    let (data, rest) = rest.split_once("</script>").unwrap();
    let (between, rest) = rest.split_once("<script>").unwrap();
    let (script, after) = rest.split_once("</script>").unwrap();
    assert!(!script.contains("<!--"), "would start a comment that swallows the end of the script");
    (format!("{before}{between}{after}"), data)
}

#[test]
fn names_cannot_break_out_of_the_page() {
    let page = render(&hostile()).unwrap();
    assert_eq!(page.matches("</script>").count(), 2, "one for the data, one for the script");
    let (markup, data) = parts(&page);
    assert!(!markup.contains("<img"));
    assert!(!data.contains('<') && !data.contains('\u{2028}'));
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(data["job"], HOSTILE);
    assert_eq!(data["motion"]["axes"][0]["name"], HOSTILE);
}

#[test]
fn nothing_is_loaded_from_anywhere() {
    let page = render(&hostile()).unwrap();
    let (markup, _) = parts(&page);
    // The policy alone forbids it in a browser; the rest of the test keeps the page honest.
    assert!(markup.contains("content=\"default-src 'none'; script-src 'unsafe-inline';"));
    for loads in [" src=\"", " href=\"", "url(", "@import", "<link", "<iframe", "http:", "https:"] {
        assert!(!markup.contains(loads), "{loads}");
    }
    let addresses: Vec<&str> = page
        .match_indices("http")
        .filter_map(|(at, _)| page.get(at..))
        .filter(|text| text.starts_with("http://") || text.starts_with("https://"))
        .map(|text| text.split(['"', '`', '\'', ' ', '\n']).next().unwrap_or_default())
        .filter(|address| !address.starts_with("http://www.w3.org/"))
        .collect();
    assert!(
        addresses.is_empty(),
        "only names of namespaces may look like addresses: {addresses:?}"
    );
}

/// The script is committed as it was built: this finds a change of its sources without a build.
#[test]
fn the_script_was_built_from_these_sources() {
    let viewer = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../viewer");
    let mut files: Vec<_> =
        fs::read_dir(viewer.join("src")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.push(viewer.join("package-lock.json"));
    let bytes = files.iter().flat_map(|file| fs::read(file).unwrap());
    // FNV-1a, as in viewer/vite.config.js.
    let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    let page = render(&ReportData::default()).unwrap();
    let built = page.split_once("viewer/, sources ").unwrap().1;
    assert!(built.starts_with(&format!("{hash:016x}.")), "run `npm run build` in viewer/");
}

#[test]
fn a_page_without_data_still_says_what_it_is() {
    let page = render(&ReportData { job: "empty".into(), ..ReportData::default() }).unwrap();
    assert!(page.contains("<title>empty: failed</title>"));
    let (_, data) = parts(&page);
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(data["motion"]["slots"], 0);
}

#[test]
fn the_same_data_make_the_same_page() {
    assert_eq!(render(&hostile()).unwrap(), render(&hostile()).unwrap());
}

#[test]
fn a_fine_grid_stays_a_file_one_can_mail() {
    let columns = 600;
    let points: Vec<_> = (0..columns * columns)
        .map(|at| {
            let [x, y] = [at % columns, at / columns].map(|k| k as f64 * 0.2);
            let deviation = Some(0.01 * (0.3 * y).sin());
            Some(SurfacePoint { position: [x, y, (0.1 * x).sin()], deviation })
        })
        .collect();
    let mut surface = Surface::default();
    surface.add_grid(columns, &points);
    let budget = Budget { total: 0.02, gouge: 0.002, shares: Vec::new() };
    let page = render(&ReportData { surface, budget, ..ReportData::default() }).unwrap();
    assert!(page.len() < 10_000_000, "{} bytes", page.len());
    let (_, data) = parts(&page);
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(data["surface"]["measured"], 360_000);
}
