//! The committed C header is the one that cbindgen makes today.

use std::fs;
use std::path::Path;
use std::process::Command;

#[test]
fn the_header_is_not_stale() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let made = Command::new("cbindgen")
        .args(["--quiet", "--config", "cbindgen.toml", "."])
        .current_dir(root)
        .output();
    let Ok(made) = made else {
        eprintln!("cbindgen is not installed: linuxcnc/trunnion_rt.h is not compared");
        return;
    };
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let made = String::from_utf8(made.stdout).unwrap();
    let file = root.join("../../linuxcnc/trunnion_rt.h");
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(&file, &made).unwrap();
    }
    let committed = fs::read_to_string(&file).unwrap();
    assert!(committed == made, "linuxcnc/trunnion_rt.h is stale: run with UPDATE_EXPECT=1");
}
