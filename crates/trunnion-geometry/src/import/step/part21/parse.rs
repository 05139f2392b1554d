//! A whole file to its records.

use super::data::StepExchange;
use super::scan::Part21Scanner;
use crate::import::error::ImportError;

impl StepExchange {
    /// Reads a whole file.
    ///
    /// # Errors
    ///
    /// [`ImportError::Syntax`] at the first place that breaks the grammar,
    /// [`ImportError::Truncated`] where the file stops before `END-ISO-10303-21;`.
    pub(in crate::import::step) fn parse(bytes: &[u8]) -> Result<Self, ImportError> {
        let mut scanner = Part21Scanner::new(bytes);
        scanner.header()?;
        let mut exchange = Self::default();
        while scanner.data_section(&mut exchange)? {}
        Ok(exchange)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::step::part21::data::StepValue;

    fn data(text: &str) -> Result<StepExchange, ImportError> {
        let file = format!("ISO-10303-21;\nHEADER;\nFILE_NAME('DATA;');\nENDSEC;\nDATA;\n{text}\n");
        StepExchange::parse(format!("{file}ENDSEC;\nEND-ISO-10303-21;\n").as_bytes())
    }

    #[test]
    fn records_keep_order_line_and_values() {
        let text = "#7 = A('it''s',(1,-2.5E1,.T.),$,*,LENGTH(3.));\n/* no */ #2=(B()C(#7));";
        let exchange = data(text).unwrap();
        let first = &exchange.instances[0];
        assert_eq!((first.id, first.line), (7, 6));
        let values = &first.part("A").unwrap().values;
        assert_eq!(values[0], StepValue::Text("it's".to_owned()));
        let list = values[1].list().unwrap();
        assert_eq!((list[0].count(), list[1].number()), (Some(1), Some(-25.0)));
        assert_eq!(list[2].truth(), Some(true));
        assert_eq!(values[4].number(), Some(3.0));
        assert_eq!(exchange.get(2).unwrap().kind(), "B+C");
        assert_eq!(exchange.line(2), 7);
        assert_eq!(exchange.get(2).unwrap().part("C").unwrap().values[0].reference(), Some(7));
    }

    #[test]
    fn faults_name_their_place() {
        let at = |text| match data(text) {
            Err(ImportError::Syntax { line, column, .. }) => (line, column),
            other => panic!("{other:?}"),
        };
        assert_eq!(at("#1 = A(1,NAN);"), (6, 13));
        assert_eq!(at("#1 = A(1E999);"), (6, 8));
        assert_eq!(at("#1 = A(1);\n#1 = A(1);"), (7, 11));
        assert_eq!(at("#1 = A(1\n#2 = B();"), (7, 1));
        let deep = format!("#1 = A{}1{};", "(".repeat(100), ")".repeat(100));
        assert_eq!(at(&deep).0, 6);
    }

    #[test]
    fn a_file_cut_short_says_so() {
        let whole = "ISO-10303-21;HEADER;ENDSEC;DATA;#1=A('x',(1.,2.));ENDSEC;END-ISO-10303-21;";
        assert!(StepExchange::parse(whole.as_bytes()).is_ok());
        for end in 13..whole.len() {
            assert!(StepExchange::parse(&whole.as_bytes()[..end]).is_err(), "{}", &whole[..end]);
        }
    }
}
