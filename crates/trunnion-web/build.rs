//! Link options of the page: the command line works on a stack of 8 MiB, the linker's default for wasm is 1 MiB.

use std::io::{self, Write};

fn main() -> io::Result<()> {
    let family = std::env::var("CARGO_CFG_TARGET_FAMILY");
    if family.is_ok_and(|family| family == "wasm") {
        io::stdout().write_all(b"cargo::rustc-link-arg-cdylib=-zstack-size=8388608\n")?;
    }
    Ok(())
}
