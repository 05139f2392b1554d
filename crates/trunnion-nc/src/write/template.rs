//! The strings around the blocks of a program: templates that a shop can print, copy and edit.

use super::format::{OUTPUT_FORMATS, OutputFormat};
use minijinja::value::Serde;
use minijinja::{Environment, ErrorKind, UndefinedBehavior};
use serde::Serialize;

/// A template, ready to be filled. Its blocks are `start`, `toolchange`, `end`, `comment` (of `text`) and `number` (of
/// `number`). One that begins with `{% extends "fanuc" %}` changes only the blocks it has.
#[derive(Debug)]
pub struct Template {
    environment: Environment<'static>,
}

/// Reason why a template cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("template, line {line}: {message}")]
#[non_exhaustive]
pub struct TemplateError {
    /// Line, counted from 1; 0 if not known.
    pub line: usize,
    /// Description of the defect.
    pub message: String,
}

impl From<minijinja::Error> for TemplateError {
    fn from(error: minijinja::Error) -> Self {
        let kind = error.kind();
        let detail = error.detail().map_or_else(|| kind.to_string(), |of| format!("{kind}: {of}"));
        Self { line: error.line().unwrap_or(0), message: detail }
    }
}

/// Name of the template in use, which may extend one of those that come.
const OWN: &str = "template";

/// Stands for what is put in later; no template has it.
const HOLE: &str = "\u{1}";

/// Values that fill a template.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct TemplateContext {
    pub(super) name: String,
    pub(super) facts: Vec<String>,
    /// Program number, four digits.
    pub(super) program: String,
    pub(super) tool: u32,
    pub(super) spindle: Option<String>,
    /// Word that starts the coolant; `None`: it stays off.
    pub(super) coolant: Option<&'static str>,
    /// Coolant runs up to here.
    pub(super) cooled: bool,
    pub(super) cutter: Option<String>,
    pub(super) offset: OffsetWords,
    pub(super) blend: Option<String>,
    pub(super) axis_tolerance: String,
    pub(super) retract: Option<String>,
    pub(super) inverse_time: bool,
    pub(super) numbers: u32,
    pub(super) tcp_on: Option<String>,
    pub(super) tcp_off: Option<String>,
    pub(super) first: StartWords,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct OffsetWords {
    pub(super) x: String,
    pub(super) y: String,
    pub(super) z: String,
}

/// Words of the starting position.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub(super) struct StartWords {
    pub(super) rotary: String,
    /// X Y Z with TCP, and without.
    pub(super) tip: String,
    pub(super) axes: String,
    pub(super) vector: String,
    /// Machine positions of the linear axes but that of the retract: the tool stands above the start, retracted.
    pub(super) above: Option<String>,
}

#[derive(Serialize)]
struct FilledContext<'a> {
    #[serde(flatten)]
    context: &'a TemplateContext,
    strings: &'a std::collections::BTreeMap<String, String>,
    text: &'static str,
    number: &'static str,
}

/// A filled template.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct TemplateFrame {
    pub(super) start: String,
    /// From one tool to the next; `None` where a shop's template has no such block.
    pub(super) toolchange: Option<String>,
    pub(super) end: String,
    /// Before and behind the text of a comment, and the number of a line.
    pub(super) comment: [String; 2],
    pub(super) number: [String; 2],
}

impl Template {
    /// Returns the built-in template of a format.
    ///
    /// # Errors
    ///
    /// [`TemplateError`].
    pub fn of(dialect: OutputFormat) -> Result<Self, TemplateError> {
        Self::new(dialect.template())
    }

    /// Reads a template from its text.
    ///
    /// # Errors
    ///
    /// [`TemplateError`] with the line.
    pub fn new(text: &str) -> Result<Self, TemplateError> {
        let mut environment = Environment::new();
        // A misspelt name in a template must fail, not leave a gap in a program.
        environment.set_undefined_behavior(UndefinedBehavior::Strict);
        for (name, dialect) in OUTPUT_FORMATS {
            environment.add_template(name, dialect.template())?;
        }
        environment.add_template_owned(OWN, text.to_owned())?;
        Ok(Self { environment })
    }

    /// Fills it; `strings` are those of the machine file.
    pub(super) fn fill(
        &self,
        context: &TemplateContext,
        strings: &std::collections::BTreeMap<String, String>,
    ) -> Result<TemplateFrame, TemplateError> {
        let filled = FilledContext { context, strings, text: HOLE, number: HOLE };
        let template = self.environment.get_template(OWN)?;
        let mut rendered = template.render_captured(Serde(&filled))?;
        let mut block = |name: &str| rendered.with_state_mut(|state| state.render_block(name));
        let [start, end] = [block("start")?, block("end")?];
        let toolchange = match block("toolchange") {
            Ok(text) => Some(text),
            Err(error) if error.kind() == ErrorKind::UnknownBlock => None,
            Err(error) => return Err(error.into()),
        };
        // Comment and number are rendered once with a mark, and later put together without the
        // engine.
        let halves = |text: String| match text.split_once(HOLE) {
            Some((before, behind)) => [before.to_owned(), behind.to_owned()],
            None => [text, String::new()],
        };
        let comment = halves(block("comment")?);
        Ok(TemplateFrame { start, toolchange, end, comment, number: halves(block("number")?) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    pub(super) fn context() -> TemplateContext {
        let none = || None;
        TemplateContext {
            name: "demo".into(),
            facts: vec!["one".into()],
            program: "0001".into(),
            tool: 1,
            spindle: Some("8000".into()),
            coolant: None,
            cooled: false,
            cutter: none(),
            offset: OffsetWords { x: "1".into(), y: "2".into(), z: "3".into() },
            blend: Some("0.01".into()),
            axis_tolerance: "0.05".into(),
            retract: none(),
            inverse_time: false,
            numbers: 0,
            tcp_on: none(),
            tcp_off: none(),
            first: StartWords { rotary: "A15. C30.".into(), ..StartWords::default() },
        }
    }

    #[test]
    fn every_template_that_comes_can_be_filled() {
        for (name, dialect) in OUTPUT_FORMATS {
            let frame = Template::of(dialect).unwrap().fill(&context(), &BTreeMap::new()).unwrap();
            assert!(!frame.start.is_empty() && !frame.end.is_empty(), "{name}");
            assert!(frame.toolchange.is_some_and(|text| text.contains('1')), "{name}");
            assert!(!frame.comment[0].is_empty(), "{name}");
        }
    }

    #[test]
    fn a_template_may_change_one_block_of_another() {
        let text = "{% extends \"fanuc\" %}{% block end %}M99{% endblock %}";
        let frame = Template::new(text).unwrap().fill(&context(), &BTreeMap::new()).unwrap();
        assert_eq!(frame.end, "M99");
        assert!(frame.start.contains("G54 G0 A15. C30."), "{}", frame.start);
    }

    #[test]
    fn faults_have_their_line() {
        let error = Template::new("{% block start %}\n{{ x \n{% endblock %}").unwrap_err();
        assert!(error.line >= 2, "{error}");
        let text = "{% extends \"fanuc\" %}{% block end %}\n{{ nothing }}{% endblock %}";
        let template = Template::new(text).unwrap();
        let error = template.fill(&context(), &BTreeMap::new()).unwrap_err();
        assert_eq!(error.line, 2, "{error}");
    }
}
