//! The engine as a JavaScript class.

use crate::answer::PageAnswer;
use crate::engine::Engine;
use crate::part_model::PartModel;
use crate::stock_model::{BrickModel, StockModel};
use crate::timeline::Timeline;
use js_sys::{Array, Float32Array, Function, Uint32Array};
use serde::Serialize;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;
use trunnion::files::machine::BUILT_IN;
use trunnion::types::{Pass, Progress, Stage};
use trunnion_cli::calls::stage_words;
use wasm_bindgen::JsValue;
use wasm_bindgen::prelude::wasm_bindgen;

thread_local! {
    /// Receiver of progress while a verb runs: JavaScript functions cannot be shared, as an observer must be.
    static RECEIVER: RefCell<Option<Function>> = const { RefCell::new(None) };
    /// Receiver of passes, likewise.
    static PASS_RECEIVER: RefCell<Option<PassReceiver>> = const { RefCell::new(None) };
    /// Words of the panic that ended the module.
    static LAST_PANIC: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Sends progress to the receiver, and stops where it returns `false`.
struct PageProgress;

impl Progress for PageProgress {
    fn report(&self, stage: Stage, done: u64, total: u64) -> ControlFlow<()> {
        RECEIVER.with_borrow(|receiver| {
            let Some(receiver) = receiver else { return ControlFlow::Continue(()) };
            let stage = JsValue::from_str(stage_words(stage));
            // Counts of steps are far below the whole numbers that a JavaScript number holds.
            let [done, total] = [done, total].map(|count| JsValue::from_f64(count as f64));
            match receiver.call3(&JsValue::NULL, &stage, &done, &total) {
                Ok(answer) if answer == JsValue::FALSE => ControlFlow::Break(()),
                // A receiver that fails must not end the work.
                _ => ControlFlow::Continue(()),
            }
        })
    }

    fn report_passes(&self, face: usize, passes: &[Arc<Pass>]) {
        PASS_RECEIVER.with_borrow_mut(|receiver| {
            if let Some(receiver) = receiver {
                receiver.send(face, passes);
            }
        });
    }
}

/// Receiver of passes, and those of each face that it has got.
struct PassReceiver {
    function: Function,
    sent: BTreeMap<usize, Vec<Arc<Pass>>>,
}

impl PassReceiver {
    /// Sends what is new: the number of the face, the number of its first passes that stay, the points of contact of those
    /// that follow, and how many each has.
    fn send(&mut self, face: usize, passes: &[Arc<Pass>]) {
        let sent = self.sent.entry(face).or_default();
        let stay = sent.iter().zip(passes).take_while(|(old, new)| Arc::ptr_eq(old, new)).count();
        if stay == sent.len() && stay == passes.len() {
            return;
        }
        let new = &passes[stay..];
        // For the eye.
        #[expect(clippy::cast_possible_truncation, reason = "see above")]
        let contacts: Vec<f32> = (new.iter().flat_map(|pass| &pass.stations))
            .flat_map(|station| <[f64; 3]>::from(station.contact.coords))
            .map(|x| x as f32)
            .collect();
        let counts: Vec<u32> =
            new.iter().map(|pass| u32::try_from(pass.stations.len()).unwrap_or(0)).collect();
        sent.truncate(stay);
        sent.extend_from_slice(new);
        // Numbers of faces and passes are far below the whole numbers that a JavaScript number holds.
        let [face, stay] = [face, stay].map(|count| JsValue::from_f64(count as f64));
        let (contacts, counts) = (Float32Array::from(&*contacts), Uint32Array::from(&*counts));
        let words = Array::of4(&face, &stay, &contacts, &counts);
        // A receiver that fails must not end the work.
        let _ = self.function.apply(&JsValue::NULL, &words);
    }
}

/// Files and verbs of a page.
#[wasm_bindgen(js_name = Engine)]
#[derive(Debug, Default)]
pub struct PageEngine {
    engine: Engine,
}

#[wasm_bindgen(js_class = Engine)]
impl PageEngine {
    /// Starts without files.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        std::panic::set_hook(Box::new(|panic| {
            LAST_PANIC.with_borrow_mut(|words| *words = panic.to_string());
        }));
        Self::default()
    }

    /// Adds a file, or replaces the one of that name.
    pub fn insert(&mut self, name: &str, bytes: Vec<u8>) {
        self.engine.insert(name, bytes);
    }

    /// Takes a file away.
    pub fn remove(&mut self, name: &str) {
        self.engine.remove(name);
    }

    /// Returns the bytes of a file or output.
    pub fn file(&self, name: &str) -> Option<Vec<u8>> {
        self.engine.file(name).map(<[u8]>::to_vec)
    }

    /// Runs a job; returns the answer as JSON. `passes` gets, as passes are placed, the number of a face, how many of the
    /// passes it got for that face stay, and x, y, z of the points of contact of those that follow, with their number for
    /// each.
    pub fn run(&mut self, job: &str, receiver: &Function, passes: Option<Function>) -> String {
        let sent = BTreeMap::new();
        PASS_RECEIVER.set(passes.map(|function| PassReceiver { function, sent }));
        let answer = receiving(receiver, || self.engine.run(job, &PageProgress));
        PASS_RECEIVER.set(None);
        json(&answer)
    }

    /// Checks a program with the options of the command line; returns the answer as JSON.
    pub fn check(&mut self, options: Vec<String>, receiver: &Function) -> String {
        let answer = receiving(receiver, || self.engine.check(&options, &PageProgress));
        json(&answer)
    }

    /// Reads a job and its files; returns the answer as JSON.
    #[wasm_bindgen(js_name = readJob)]
    pub fn read_job(&mut self, job: &str) -> String {
        json(&self.engine.read_job(job))
    }

    /// Proposes a job with the options of `trunnion init`; returns the answer as JSON.
    pub fn propose(&mut self, options: Vec<String>, receiver: &Function) -> String {
        let answer = receiving(receiver, || self.engine.propose(&options, &PageProgress));
        json(&answer)
    }

    /// Reads a part, turns it about its x, then y, then z by three angles in degrees, and draws its faces. Without three
    /// angles it stays as it is drawn.
    ///
    /// # Errors
    ///
    /// The messages of the command line, one a line.
    pub fn part(&mut self, name: &str, angles: Option<Vec<f64>>) -> Result<PagePart, JsValue> {
        let angles = angles.and_then(|angles| angles.try_into().ok()).unwrap_or_default();
        let part = self.engine.part(name, angles);
        part.map(PagePart).map_err(|messages| JsValue::from_str(&messages.join("\n")))
    }

    /// Returns the chain of a machine file or built-in machine as JSON.
    ///
    /// # Errors
    ///
    /// The messages of the command line, one a line.
    pub fn machine(&mut self, name: &str) -> Result<String, JsValue> {
        data(self.engine.machine(name))
    }

    /// Returns a library as JSON, the standard one without a name.
    ///
    /// # Errors
    ///
    /// The messages of the command line, one a line.
    pub fn library(&mut self, name: Option<String>) -> Result<String, JsValue> {
        data(self.engine.library(name.as_deref()))
    }

    /// Prepares the stock of a program to be cut in a picture, with rays about `cell` \[mm\] apart.
    ///
    /// # Errors
    ///
    /// The messages of the command line, one a line.
    pub fn stock(&mut self, options: Vec<String>, cell: f64) -> Result<Option<PageStock>, JsValue> {
        let stock = self.engine.stock(&options, cell);
        let stock = stock.map(|found| found.map(PageStock));
        stock.map_err(|messages| JsValue::from_str(&messages.join("\n")))
    }

    /// Returns the moves of a program over time.
    ///
    /// # Errors
    ///
    /// The messages of the command line, one a line.
    pub fn timeline(&mut self, options: Vec<String>) -> Result<PageTimeline, JsValue> {
        let timeline = self.engine.timeline(&options);
        timeline.map(PageTimeline).map_err(|messages| JsValue::from_str(&messages.join("\n")))
    }
}

/// Words of the panic that ended the module; empty if none did.
#[wasm_bindgen(js_name = lastPanic)]
pub fn last_panic() -> String {
    LAST_PANIC.with_borrow(Clone::clone)
}

/// Version of the engine.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// Moves of a program as typed arrays.
#[wasm_bindgen(js_name = Timeline)]
#[derive(Debug)]
pub struct PageTimeline(Timeline);

#[wasm_bindgen(js_class = Timeline)]
impl PageTimeline {
    /// Times \[s\].
    pub fn times(&self) -> Vec<f64> {
        self.0.times.clone()
    }

    /// Lines of the program.
    pub fn lines(&self) -> Vec<u32> {
        self.0.lines.clone()
    }

    /// Tool, rapid and apart, packed.
    pub fn kinds(&self) -> Vec<u32> {
        self.0.kinds.clone()
    }

    /// Axes \[mm, rad\].
    pub fn axes(&self) -> Vec<f64> {
        self.0.axes.clone()
    }

    /// Tips \[mm\] and tool axes.
    pub fn poses(&self) -> Vec<f32> {
        self.0.poses.clone()
    }

    /// Machine, tools and the presence of stock as JSON.
    pub fn model(&self) -> String {
        let Timeline { machine, tools, has_stock, .. } = &self.0;
        serde_json::json!({ "machine": machine, "tools": tools, "has_stock": has_stock })
            .to_string()
    }
}

/// Stock of a program as it is cut.
#[wasm_bindgen(js_name = Stock)]
#[derive(Debug)]
pub struct PageStock(StockModel);

#[wasm_bindgen(js_class = Stock)]
impl PageStock {
    /// Largest distance of its rays \[mm\], and its origin, as JSON.
    pub fn model(&self) -> String {
        serde_json::json!({ "cell": self.0.cell(), "is_stated": self.0.is_stated() }).to_string()
    }

    /// Returns the time at the end of the program \[s\].
    pub fn end(&self) -> f64 {
        self.0.stock().end()
    }

    /// Goes towards a time \[s\] by at most so many moves; returns the time that it has come to \[s\].
    ///
    /// # Errors
    ///
    /// The messages of the command line, one a line.
    pub fn cut(&mut self, time: f64, moves: usize) -> Result<f64, JsValue> {
        self.0.cut(time, moves).map_err(|message| JsValue::from_str(&message))
    }

    /// Returns the bricks whose surface has changed since the last call.
    ///
    /// # Errors
    ///
    /// The messages of the command line, one a line.
    pub fn changes(&mut self) -> Result<PageBricks, JsValue> {
        self.0.changes().map(PageBricks).map_err(|message| JsValue::from_str(&message))
    }
}

/// Bricks of the surface of stock as typed arrays.
#[wasm_bindgen(js_name = Bricks)]
#[derive(Debug)]
pub struct PageBricks(BrickModel);

#[wasm_bindgen(js_class = Bricks)]
impl PageBricks {
    /// Number, vertices and triangles of each brick.
    pub fn counts(&self) -> Vec<u32> {
        self.0.counts.clone()
    }

    /// Vertices \[mm\], brick by brick.
    pub fn positions(&self) -> Vec<f32> {
        self.0.positions.clone()
    }

    /// Triangles, brick by brick; each counts its own vertices.
    pub fn triangles(&self) -> Vec<u32> {
        self.0.triangles.clone()
    }
}

/// Faces of a part as typed arrays.
#[wasm_bindgen(js_name = Part)]
#[derive(Debug)]
pub struct PagePart(PartModel);

#[wasm_bindgen(js_class = Part)]
impl PagePart {
    /// Vertices \[mm\].
    pub fn positions(&self) -> Vec<f32> {
        self.0.positions.clone()
    }

    /// Triangles, face by face.
    pub fn triangles(&self) -> Vec<u32> {
        self.0.triangles.clone()
    }

    /// Edges \[mm\].
    pub fn edges(&self) -> Vec<f32> {
        self.0.edges.clone()
    }

    /// Faces and warnings as JSON.
    pub fn model(&self) -> String {
        serde_json::json!({ "faces": self.0.faces, "warnings": self.0.warnings }).to_string()
    }
}

/// Names of the built-in machines.
#[wasm_bindgen]
pub fn machines() -> Vec<String> {
    BUILT_IN.iter().map(|(name, _)| (*name).to_owned()).collect()
}

/// Runs work whose progress goes to `receiver`.
fn receiving(receiver: &Function, work: impl FnOnce() -> PageAnswer) -> PageAnswer {
    RECEIVER.set(Some(receiver.clone()));
    let answer = work();
    RECEIVER.set(None);
    answer
}

/// Turns data or messages into what a page gets.
fn data(found: Result<impl Serialize, Vec<String>>) -> Result<String, JsValue> {
    let found = found.map_err(|messages| JsValue::from_str(&messages.join("\n")))?;
    // Strings and numbers alone: it cannot fail.
    Ok(serde_json::to_string(&found).unwrap_or_default())
}

fn json(answer: &PageAnswer) -> String {
    // Strings and numbers alone: it cannot fail.
    serde_json::to_string(answer).unwrap_or_default()
}
