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
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{dialect} {input}: {told}");
        let text = fs::read_to_string(folder.path().join(out)).unwrap();
        (text.lines().map(str::to_owned).collect::<Vec<_>>(), told)
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
            let (first, told) = post("in.ngc", dialect, name, &[]);
            assert_eq!(coolant(&first, dialect), wanted, "{dialect} {codes:?}");
            assert!(!told.contains("coolant"), "{told}");
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
    // Coolant that is switched between the cuts of one tool is not carried, and said so.
    let mixed = cooled_tools(["", "M8"]).replace("X20\n", "M8\nX20\n");
    fs::write(folder.path().join("in.ngc"), mixed).unwrap();
    let (_, told) = post("in.ngc", "fanuc", "mixed.nc", &[]);
    assert!(told.contains("in.ngc:10: the coolant is switched"), "{told}");
}
