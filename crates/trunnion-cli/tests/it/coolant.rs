//! Coolant that `trunnion post` carries from its input to every dialect.

use crate::binary::trunnion;
use crate::post::DIALECTS;
use std::fs;

/// Cuts of two tools; the coolant starts behind the first rapid move of each.
fn cooled_tools(codes: [&str; 2]) -> String {
    let [one, two] = codes;
    format!(
        "G21 G90 G17 G40 G80 G54 G94\nT1 M6\nS5000 M3\nG43 H1\nG0 X0 Y0\nG0 Z20\n{one}\nG1 Z-1 F500\nX20\nG0 Z50\n\
         M9\nT2 M6\nS8000 M3\nG43 H2\nG0 X5 Y5\nG0 Z20\n{two}\nG1 Z-2 F500\nY20\nG0 Z50\nM9\nM2\n"
    )
}

/// The coolant of each tool's cuts goes through every dialect and back, and no warning speaks of it.
#[test]
fn the_coolant_of_the_input_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let lengths = ["--tool-length", "1=100", "--tool-length", "2=80", "--origin=0,0,-430"];
    let post = |input: &str, dialect: &str, out: &str, more: &[&str]| {
        let mut arguments = vec![input, "-m", "ac-trunnion", "-d", dialect, "-o", out];
        arguments.extend(lengths);
        arguments.extend(more);
        let output = trunnion(folder.path(), &[vec!["post"], arguments].concat());
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{dialect} {input}: {errors}");
        let text = fs::read_to_string(folder.path().join(out)).unwrap();
        (text.lines().map(str::to_owned).collect::<Vec<_>>(), errors)
    };
    // Codes in the order of the program, as its dialect writes them.
    let coolant = |lines: &[String], dialect: &str| -> Vec<String> {
        let code = |line: &String| match dialect {
            "apt" => line.strip_prefix("COOLNT/").map(str::to_owned),
            _ => ["M7", "M8", "M9"]
                .into_iter()
                .find(|code| line.split_whitespace().any(|word| word == *code))
                .map(str::to_owned),
        };
        lines.iter().filter_map(code).collect()
    };
    let cases: [([&str; 2], &[&str], &[&str]); 4] = [
        (["M8", "M8"], &["M8", "M9", "M8", "M9"], &["ON", "ON", "OFF"]),
        (["M7", "(no M8 here)"], &["M7", "M9"], &["MIST", "OFF"]),
        (["", "M8"], &["M8", "M9"], &["ON", "OFF"]),
        (["", ""], &[], &[]),
    ];
    for (codes, wanted, of_cl) in cases {
        fs::write(folder.path().join("in.ngc"), cooled_tools(codes)).unwrap();
        for dialect in DIALECTS {
            let wanted = if dialect == "apt" { of_cl } else { wanted };
            let wanted: Vec<&str> = match dialect {
                // The tool change leaves the coolant running from tool to tool.
                "heidenhain" | "heidenhain-axes" if wanted.len() == 4 => vec!["M8", "M8", "M9"],
                _ => wanted.to_vec(),
            };
            let name = if dialect == "apt" { "first.cls" } else { "first.nc" };
            let (first, errors) = post("in.ngc", dialect, name, &[]);
            assert_eq!(coolant(&first, dialect), wanted, "{dialect} {codes:?}");
            assert!(!errors.contains("coolant"), "{errors}");
            // Read again, it is the coolant of LinuxCNC.
            let (again, _) = post(name, "linuxcnc", "again.ngc", &[]);
            let linuxcnc = if wanted.len() == 3 {
                &cases[0].1
            } else {
                cases.iter().find(|case| case.0 == codes).map(|case| &case.1).unwrap()
            };
            assert_eq!(coolant(&again, "linuxcnc"), *linuxcnc, "{dialect} {codes:?}");
        }
    }
    // The option starts it for all tools.
    fs::write(folder.path().join("in.ngc"), cooled_tools(["", ""])).unwrap();
    let (forced, _) = post("in.ngc", "fanuc", "forced.nc", &["--coolant"]);
    assert_eq!(coolant(&forced, "fanuc"), ["M8", "M9", "M8", "M9"]);
}

/// Coolant that is switched between the cuts of one tool, or within a cut, is switched there in every dialect and behind
/// every filter, and back.
#[test]
fn a_switch_of_the_coolant_stays_between_its_moves() {
    let folder = tempfile::tempdir().unwrap();
    let input = "G21 G90 G17 G40 G80 G54 G94\nT1 M6\nS5000 M3\nG43 H1\nG0 X0 Y0\nG0 Z20\nG1 Z-1 F500\nX10\nM8\nX20\nX30 Y1\n\
                 M7\nX40\nM9\nM7\nG0 Z20\nX0\nG1 Z-2\nY10\nM9\nY20\nG0 Z50\nM2\n";
    fs::write(folder.path().join("in.ngc"), input).unwrap();
    let post = |input: &str, dialect: &str, out: &str, filter: &[&str]| {
        let mut arguments = vec!["post", input, "-m", "ac-trunnion", "-d", dialect, "-o", out];
        arguments.extend(["--tool-length", "100", "--origin=0,0,-430"]);
        arguments.extend(filter);
        let output = trunnion(folder.path(), &arguments);
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{dialect} {input}: {errors}");
        assert!(!errors.contains("coolant"), "{errors}");
        fs::read_to_string(folder.path().join(out)).unwrap()
    };
    // Coolant of the moves from the first cut on.
    let course = |text: &str, dialect: &str| -> String {
        let (mut running, mut course) = (String::new(), Vec::new());
        let mut cuts = false;
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            let has = |word: &str| words.contains(&word);
            running = match dialect {
                "apt" if line == "COOLNT/OFF" => String::new(),
                "apt" if line == "COOLNT/MIST" => "7".to_owned(),
                "apt" if line == "COOLNT/ON" => "8".to_owned(),
                _ if has("M9") => String::new(),
                _ if has("M7") && !running.contains('7') => format!("{running}7"),
                _ if has("M8") && !running.contains('8') => format!("{running}8"),
                _ => running,
            };
            let rapid = match dialect {
                "apt" => line == "RAPID",
                "heidenhain" | "heidenhain-axes" => has("FMAX"),
                _ => has("G0"),
            };
            let goes = |word: &&str| word.starts_with(['X', 'Y', 'Z']) && word.len() > 1;
            let moves = line.starts_with("GOTO/") || words.iter().any(goes);
            cuts |= line.contains('F') && !rapid && moves || line.starts_with("FEDRAT/");
            if cuts && moves && course.last() != Some(&running) {
                course.push(running.clone());
            }
        }
        course.join(",")
    };
    // The cut without, with flood, with both, with mist, without again; the end switches off what runs.
    let (wanted, of_cl) = (",8,87,7,", ",8,7,");
    for dialect in DIALECTS {
        for filter in [&[][..], &["--reduce"], &["--smooth"]] {
            let name = if dialect == "apt" { "out.cls" } else { "out.nc" };
            let text = post("in.ngc", dialect, name, filter);
            let found = course(&text, dialect).replace("78", "87");
            let wanted = if dialect == "apt" { of_cl } else { wanted };
            assert_eq!(found, wanted, "{dialect} {filter:?}\n{text}");
            let back = post(name, "linuxcnc", "back.ngc", filter);
            let found = course(&back, "linuxcnc").replace("78", "87");
            assert_eq!(found, wanted, "{dialect} {filter:?}, back\n{back}");
        }
    }
}
