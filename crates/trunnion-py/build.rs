//! Link options of an extension module: its Python symbols come from the interpreter that loads it.

fn main() {
    // Other linkers leave symbols of a shared library open without being asked.
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("macos") {
        let options = ["-undefined", "dynamic_lookup"];
        let lines = options.map(|option| format!("cargo::rustc-cdylib-link-arg={option}\n"));
        let _ = std::io::Write::write_all(&mut std::io::stdout(), lines.concat().as_bytes());
    }
}
