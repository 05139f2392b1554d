//! Units: factors from the file's lengths to mm, and from its angles to rad.

use super::model::ASSUMED;
use super::model::MAX_CHAIN;
use super::model::Read;
use super::model::StepModel;
use super::model::UnitScale;
use super::model::loss;
use super::part21::StepExchange;
use super::part21::StepInstance;

/// Millimetres in a metre.
const METRE: f64 = 1000.0;

/// Reads the unit context `id`, if it is one: a representation context that assigns global units.
///
/// `Ok(None)` if `id` assigns no units at all.
pub(super) fn scale(exchange: &StepExchange, id: u64) -> Read<Option<UnitScale>> {
    let model = StepModel::plain(exchange);
    let Some(instance) = exchange.get(id) else { return Ok(None) };
    let Some(fields) = StepModel::part(instance, "GLOBAL_UNIT_ASSIGNED_CONTEXT") else {
        return Ok(None);
    };
    let mut scale = ASSUMED;
    let mut lengths = 0;
    for unit in fields.references(0)? {
        let instance = model.instance(unit, id)?;
        if instance.part("LENGTH_UNIT").is_some() {
            scale.length = factor(&model, instance, METRE, 0)?;
            lengths += 1;
        } else if instance.part("PLANE_ANGLE_UNIT").is_some() {
            scale.angle = factor(&model, instance, 1.0, 0)?;
        }
    }
    if lengths == 1 {
        return Ok(Some(scale));
    }
    loss(id, format!("the context names {lengths} units of length where one is due"))
}

/// Returns the factor of a unit, if that of the SI unit behind it is `si`.
fn factor(model: &StepModel<'_>, unit: &StepInstance, si: f64, depth: usize) -> Read<f64> {
    if depth > MAX_CHAIN {
        return loss(unit.id, "the unit is defined by itself");
    }
    if let Some(fields) = StepModel::part(unit, "SI_UNIT") {
        return Ok(si * prefix(fields.values.first(), unit.id)?);
    }
    let Some(fields) = StepModel::part(unit, "CONVERSION_BASED_UNIT") else {
        return loss(unit.id, format!("{} is not a unit this reader knows", unit.kind()));
    };
    let names = ["LENGTH_MEASURE_WITH_UNIT", "PLANE_ANGLE_MEASURE_WITH_UNIT", "MEASURE_WITH_UNIT"];
    let measure = model.named(fields.reference(1)?, unit.id, &names)?;
    let base = model.instance(measure.reference(1)?, measure.id)?;
    // An inch is 2.54 of a centimetre, which is a hundredth of a metre: factors multiply.
    let factor = measure.number(0)? * factor(model, base, si, depth + 1)?;
    if factor > 0.0 && factor.is_finite() {
        return Ok(factor);
    }
    loss(unit.id, format!("the unit is {factor} times the SI unit; it must be positive"))
}

fn prefix(value: Option<&super::part21::StepValue>, id: u64) -> Read<f64> {
    let Some(super::part21::StepValue::Word(word)) = value else { return Ok(1.0) };
    let power = match word.as_str() {
        "NANO" => -9,
        "MICRO" => -6,
        "MILLI" => -3,
        "CENTI" => -2,
        "DECI" => -1,
        "DECA" => 1,
        "HECTO" => 2,
        "KILO" => 3,
        "MEGA" => 6,
        other => return loss(id, format!("{other} is not a prefix of a length this reader knows")),
    };
    Ok(10.0_f64.powi(power))
}

/// Finds the first context of the file that states units.
pub(super) fn first(exchange: &StepExchange) -> Option<UnitScale> {
    exchange.instances.iter().find_map(|instance| scale(exchange, instance.id).ok().flatten())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(units: &str) -> f64 {
        let text = format!(
            "ISO-10303-21;HEADER;ENDSEC;DATA;{units}\
             #9=(GLOBAL_UNIT_ASSIGNED_CONTEXT((#1,#5))REPRESENTATION_CONTEXT('',''));\
             #5=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()CONVERSION_BASED_UNIT('DEGREE',#6));\
             #6=PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.0174532925),#7);\
             #7=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));\
             ENDSEC;END-ISO-10303-21;"
        );
        let scale = first(&StepExchange::parse(text.as_bytes()).unwrap()).unwrap();
        assert!((scale.angle.to_degrees() - 1.0).abs() < 1e-8);
        scale.length
    }

    #[test]
    fn inch_metre_and_millimetre() {
        let metre = "#1=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.));";
        assert!((length(metre) - 1000.0).abs() < 1e-9);
        let milli = "#1=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));";
        assert!((length(milli) - 1.0).abs() < 1e-12);
        let inch = "#1=(CONVERSION_BASED_UNIT('INCH',#2)LENGTH_UNIT()NAMED_UNIT(*));\
             #2=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(2.54),#3);\
             #3=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.CENTI.,.METRE.));";
        assert!((length(inch) - 25.4).abs() < 1e-12);
    }
}
