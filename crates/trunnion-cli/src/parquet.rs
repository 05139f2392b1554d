//! Motion tables as Parquet: columns of f64, as the CSV names them.

use parquet::basic::{Repetition, Type as Physical};
use parquet::data_type::DoubleType;
use parquet::errors::Result;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io::{Error, Write};
use std::sync::Arc;

/// Rows of a group, which is what is in memory at a time: 11 MB with four tables of five axes.
const GROUP: usize = 1 << 16;

/// Writes rows of `names`; a row has as many values.
pub(crate) fn write(
    out: impl Write + Send,
    names: &[String],
    rows: impl Iterator<Item = Vec<f64>>,
) -> std::io::Result<()> {
    table(out, names, rows).map_err(Error::other)
}

fn table(
    out: impl Write + Send,
    names: &[String],
    rows: impl Iterator<Item = Vec<f64>>,
) -> Result<()> {
    let column = |name: &String| {
        let column = Type::primitive_type_builder(name, Physical::DOUBLE);
        column.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
    };
    let columns = names.iter().map(column).collect::<Result<Vec<_>>>()?;
    let schema = Type::group_type_builder("motion").with_fields(columns).build()?;
    // Hardly any value occurs twice: a dictionary would only add to the file.
    let properties = WriterProperties::builder().set_dictionary_enabled(false).build();
    let mut file = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))?;
    let mut rows = rows.peekable();
    while rows.peek().is_some() {
        let mut group = vec![Vec::with_capacity(GROUP); names.len()];
        for row in rows.by_ref().take(GROUP) {
            group.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        }
        let mut writer = file.next_row_group()?;
        let mut columns = group.iter();
        while let (Some(mut column), Some(values)) = (writer.next_column()?, columns.next()) {
            column.typed::<DoubleType>().write_batch(values, None, None)?;
            column.close()?;
        }
        writer.close()?;
    }
    file.close()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    #[test]
    fn what_is_written_is_read_again() {
        let names = ["t", "X"].map(str::to_owned);
        let value = |row: usize| [row as f64 * 0.001, (row as f64).sin()];
        let count = GROUP + 5;
        let mut file = tempfile::tempfile().unwrap();
        write(&mut file, &names, (0..count).map(|row| value(row).to_vec())).unwrap();
        let file = SerializedFileReader::new(file).unwrap();
        assert_eq!(file.metadata().num_row_groups(), 2);
        let rows = file.get_row_iter(None).unwrap();
        let mut read = 0;
        for (at, row) in rows.enumerate() {
            let row = row.unwrap();
            let got = [row.get_double(0).unwrap(), row.get_double(1).unwrap()];
            assert_eq!(got.map(f64::to_bits), value(at).map(f64::to_bits));
            read += 1;
        }
        assert_eq!(read, count);
    }
}
