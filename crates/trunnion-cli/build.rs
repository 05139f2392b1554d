//! Packs the built site of the studio into the binary, where the feature `studio` asks for it.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::{env, fmt, fs};

fn main() -> io::Result<()> {
    instruct("rerun-if-changed=build.rs")?;
    let mut list = String::from("&[\n");
    if env::var_os("CARGO_FEATURE_STUDIO").is_some() {
        let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
        let site = here.join("../../studio/dist");
        instruct(&format!("rerun-if-changed={}", site.display()))?;
        if site.join("index.html").is_file() {
            pack(&site, &mut list)?;
        } else {
            let help = "build it first (just studio), or leave the feature `studio` out";
            instruct(&format!("error=the feature `studio` needs the site in studio/dist: {help}"))?;
        }
    }
    list.push(']');
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    fs::write(out.join("site.rs"), list)
}

/// Prints an instruction for cargo.
fn instruct(what: &str) -> io::Result<()> {
    writeln!(io::stdout(), "cargo::{what}")
}

/// Adds the files of the site to a list of their names and bytes.
fn pack(site: &Path, list: &mut String) -> io::Result<()> {
    for file in files(site)? {
        let name = file.strip_prefix(site).unwrap_or(&file).to_string_lossy().replace('\\', "/");
        let path = fs::canonicalize(&file)?;
        let path = path.to_string_lossy();
        // Writing to a string never fails.
        let _ = fmt::Write::write_fmt(
            list,
            format_args!("    ({name:?}, include_bytes!({path:?})),\n"),
        );
    }
    Ok(())
}

/// Returns the files below a folder, in order.
fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(files(&path)?);
        } else {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}
