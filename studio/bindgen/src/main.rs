//! Writes the JavaScript module of a compiled engine: `bindgen ENGINE.wasm FOLDER`.

use std::error::Error;
use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args_os().skip(1);
    let (Some(engine), Some(folder)) = (words.next(), words.next()) else {
        return Err("the engine and the folder to write are needed".into());
    };
    let mut bindgen = Bindgen::new();
    // The module finds the engine beside itself; the bundler renames both.
    bindgen.input_path(engine).typescript(true).web(true)?.omit_default_module_path(false);
    bindgen.generate(folder)?;
    Ok(())
}
