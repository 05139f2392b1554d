//! Cuts a box of stock by the moves of a CL file: volume taken away, time. Used beside other engines in
//! `benches/peers/verify`.
//!
//!     cargo run --release --example cut_stock -- moves.cls 10,6,60 -50,-30,-20,50,30,0 0.1

use nalgebra::Point3;
use std::time::Instant;
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::types::Silent;
use trunnion::verify::{self, CheckInput, Solid, Stock};

type Failure = Box<dyn std::error::Error>;

fn numbers<const N: usize>(text: Option<String>, wanted: &str) -> Result<[f64; N], Failure> {
    let text = text.ok_or_else(|| format!("{wanted} is missing"))?;
    let numbers: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
    numbers?.try_into().map_err(|_| format!("{wanted} are {N} numbers").into())
}

#[expect(clippy::print_stdout, reason = "an example tells its result")]
fn main() -> Result<(), Failure> {
    let mut arguments = std::env::args().skip(1);
    let text = std::fs::read_to_string(arguments.next().ok_or("a CL file is missing")?)?;
    let [major, minor, length] = numbers(arguments.next(), "R,r,length")?;
    let [x, y, z, u, v, w] = numbers(arguments.next(), "corners of the stock")?;
    let [cell] = numbers(arguments.next(), "distance of the rays")?;
    let spec = CutterSpec { length, ..CutterSpec::of_radii(major, minor) };
    let cutter = Cutter::new(spec)?;
    let file = trunnion::nc::read::cl(&text, 1)?;
    let solid = Solid::Box { low: Point3::new(x, y, z), high: Point3::new(u, v, w) };
    let mut stock = Stock::new(&solid, cell, 100_000_000)?;
    let input = CheckInput::locations(&file, &cutter);
    let start = Instant::now();
    let cut =
        verify::simulate(&input, &mut stock, &verify::StockOptions::within(0.01 * cell), &Silent)?;
    let seconds = start.elapsed().as_secs_f64();
    let [along_x, along_y, along_z] = stock.volumes();
    println!("{} {seconds} {along_x} {along_y} {along_z}", cut.removed);
    Ok(())
}
