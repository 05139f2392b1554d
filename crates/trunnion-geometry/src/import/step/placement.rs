//! Assemblies: the placements of a representation in the file's common frame.

use super::model::FaceLoss;
use super::model::MAX_CHAIN;
use super::model::Read;
use super::model::StepModel;
use super::model::loss;
use super::part21::StepExchange;
use super::part21::StepInstance;
use super::part21::StepValue;
use super::units;
use nalgebra::Isometry3;
use nalgebra::Rotation3;
use nalgebra::Translation3;
use nalgebra::UnitQuaternion;
use std::collections::BTreeMap;
use std::collections::BTreeSet;

/// Most copies of one part that are read. Screws may come by the hundred; a chain of doublings in
/// a damaged file would come by the million.
const MAX_COPIES: usize = 1000;

/// `parent_from_child` of one use of a representation.
#[derive(Debug, Clone, Copy)]
struct PlacementStep {
    parent: u64,
    parent_from_child: Isometry3<f64>,
}

/// Placements of representations in each other.
#[derive(Debug, Default)]
pub(super) struct PartPlacements {
    /// Uses of a representation, in file order.
    steps: BTreeMap<u64, Vec<PlacementStep>>,
    /// Representations of the same thing in the same place, both ways.
    same: BTreeMap<u64, Vec<u64>>,
}

impl PartPlacements {
    /// Reads all relationships of a file, and what could not be read of them.
    pub(super) fn read(exchange: &StepExchange) -> (Self, Vec<FaceLoss>) {
        let mut placements = Self::default();
        let mut losses = Vec::new();
        for instance in &exchange.instances {
            if let Err(loss) = placements.add(exchange, instance) {
                losses.push(loss);
            }
        }
        (placements, losses)
    }

    fn add(&mut self, exchange: &StepExchange, instance: &StepInstance) -> Read<()> {
        let model = StepModel::plain(exchange);
        let placing = "REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION";
        if let (Some(pair), Some(fields)) = (
            StepModel::part(instance, "REPRESENTATION_RELATIONSHIP"),
            StepModel::part(instance, placing),
        ) {
            let names = ["ITEM_DEFINED_TRANSFORMATION"];
            let items = model.named(fields.reference(0)?, instance.id, &names)?;
            let items = [items.reference(2)?, items.reference(3)?];
            let [a, b] = [pair.reference(2)?, pair.reference(3)?];
            // The first is placed in the second; some files name them the other way round.
            let swapped = holds(exchange, a, items[1]) && holds(exchange, b, items[0]);
            let [child, parent] = if swapped { [b, a] } else { [a, b] };
            return self.place(exchange, [child, parent], items, instance.id);
        }
        if let Some(fields) = StepModel::part(instance, "SHAPE_REPRESENTATION_RELATIONSHIP")
            && let (Ok(a), Ok(b)) = (fields.reference(2), fields.reference(3))
        {
            // Equivalent both ways: files keep geometry and product structure in two
            // representations.
            self.same.entry(a).or_default().push(b);
            self.same.entry(b).or_default().push(a);
        }
        let Some(items) = StepModel::simple(instance)
            .filter(|fields| fields.name.ends_with("REPRESENTATION"))
            .and_then(|fields| fields.values.get(1).and_then(StepValue::list))
        else {
            return Ok(());
        };
        for item in items.iter().filter_map(StepValue::reference) {
            let Some(mapped) = exchange.get(item).and_then(|i| StepModel::part(i, "MAPPED_ITEM"))
            else {
                continue;
            };
            // A mapped item repeats a representation: its origin falls on the target of the map.
            let map = model.named(mapped.reference(1)?, item, &["REPRESENTATION_MAP"])?;
            let frames = [map.reference(0)?, mapped.reference(2)?];
            self.place(exchange, [map.reference(1)?, instance.id], frames, item)?;
        }
        Ok(())
    }

    /// Places the child so that its frame `inner` falls on the frame `outer` of the parent.
    fn place(
        &mut self,
        exchange: &StepExchange,
        [child, parent]: [u64; 2],
        [inner, outer]: [u64; 2],
        from: u64,
    ) -> Read<()> {
        let inner = isometry(exchange, child, inner, from)?;
        let outer = isometry(exchange, parent, outer, from)?;
        // parent <- frame (outer), frame <- child (inverse of inner).
        let parent_from_child = outer * inner.inverse();
        self.steps.entry(child).or_default().push(PlacementStep { parent, parent_from_child });
        Ok(())
    }

    /// Returns `file_from_representation`, once for every use.
    pub(super) fn of(&self, representation: u64) -> Read<Vec<Isometry3<f64>>> {
        let mut found = Vec::new();
        self.climb(representation, Isometry3::identity(), 0, &mut found)?;
        Ok(found)
    }

    fn climb(
        &self,
        representation: u64,
        here: Isometry3<f64>,
        depth: usize,
        found: &mut Vec<Isometry3<f64>>,
    ) -> Read<()> {
        if depth > MAX_CHAIN {
            return loss(representation, "the assembly contains itself");
        }
        let mut top = true;
        // A part used twice is reached on two paths, and read as two copies.
        for same in self.alike(representation) {
            for step in self.steps.get(&same).into_iter().flatten() {
                top = false;
                self.climb(step.parent, step.parent_from_child * here, depth + 1, found)?;
            }
        }
        // No one uses it: its frame is that of the file.
        if top {
            found.push(here);
        }
        if found.len() > MAX_COPIES {
            return loss(representation, format!("placed more than {MAX_COPIES} times"));
        }
        Ok(())
    }

    /// Returns the representation and those equivalent to it.
    fn alike(&self, representation: u64) -> BTreeSet<u64> {
        let mut all = BTreeSet::from([representation]);
        let mut fresh = vec![representation];
        while let Some(next) = fresh.pop() {
            for &other in self.same.get(&next).into_iter().flatten() {
                if all.insert(other) {
                    fresh.push(other);
                }
            }
        }
        all
    }
}

/// Returns `true` if the representation lists `item`.
fn holds(exchange: &StepExchange, representation: u64, item: u64) -> bool {
    exchange
        .get(representation)
        .and_then(StepModel::simple)
        .and_then(|fields| fields.values.get(1).and_then(StepValue::list))
        .is_some_and(|items| items.contains(&StepValue::Reference(item)))
}

/// Reads a frame of a representation, in the representation's units.
fn isometry(
    exchange: &StepExchange,
    representation: u64,
    frame: u64,
    from: u64,
) -> Read<Isometry3<f64>> {
    let context = exchange
        .get(representation)
        .and_then(StepModel::simple)
        .and_then(|fields| fields.values.get(2).and_then(StepValue::reference));
    // A length in the child and one in the parent may have different units.
    let scale = match context {
        Some(context) => units::scale(exchange, context)?,
        None => None,
    };
    let scale = scale.or_else(|| units::first(exchange)).unwrap_or(super::model::ASSUMED);
    let model = StepModel { scale, ..StepModel::plain(exchange) };
    let frame = model.frame(frame, from)?;
    let axes = [frame.x.into_inner(), frame.y.into_inner(), frame.z.into_inner()];
    // The axes are orthonormal and right-handed by construction.
    let rotation = Rotation3::from_basis_unchecked(&axes);
    let translation = Translation3::from(frame.origin.coords);
    Ok(Isometry3::from_parts(translation, UnitQuaternion::from_rotation_matrix(&rotation)))
}
