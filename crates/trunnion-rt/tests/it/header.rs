//! The committed C header is the one that cbindgen makes today.

use std::fs;
use std::path::Path;

#[test]
fn the_header_is_not_stale() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).unwrap();
    let header = cbindgen::Builder::new().with_crate(root).with_config(config).generate().unwrap();
    let mut made = Vec::new();
    header.write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let file = root.join("../../linuxcnc/trunnion_rt.h");
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(&file, &made).unwrap();
    }
    let committed = fs::read_to_string(&file).unwrap();
    assert!(committed == made, "linuxcnc/trunnion_rt.h is stale: run with UPDATE_EXPECT=1");
}
