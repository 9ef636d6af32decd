//! Every variant of every program: what `-D` definitions a scene can lead to.
//!
//! A method that gains a feature gains it here, so that the tests build it on every device. A test also checks that
//! the programs of real plans stand in this table.

use crate::device::ProgramSpec;

/// A definition and the values it takes; `""` is "not defined".
type Choice = (&'static str, &'static [&'static str]);

/// A feature that is compiled in or not.
const SWITCH: &[&str] = &["", "1"];

/// What every program of a volume may need.
const COMMON: [Choice; 4] = [
    ("VOXEL", &["uchar", "char", "ushort", "short", "float"]),
    ("FILTER_BOX", SWITCH),
    ("THIN_LENS", SWITCH),
    ("ENVIRONMENT", SWITCH),
];

/// The variants of one kernel.
pub struct Family {
    /// Path below `cl/`.
    pub entry: &'static str,
    /// The kernel.
    pub kernel: &'static str,
    own: &'static [Choice],
    /// Definitions that need another one, any of those named.
    needs: &'static [(&'static str, &'static [&'static str])],
    /// Pairs of definitions that exclude each other.
    excludes: &'static [(&'static str, &'static str)],
}

/// All kernels that render.
pub const FAMILIES: [Family; 3] = [
    Family { entry: "render/mip.cl", kernel: "render_mip", own: &[], needs: &[], excludes: &[] },
    Family {
        entry: "render/isosurface.cl",
        kernel: "render_isosurface",
        own: &[],
        needs: &[],
        excludes: &[],
    },
    Family {
        entry: "render/emission_absorption.cl",
        kernel: "render_emission_absorption",
        own: &[
            ("TF_2D", SWITCH),
            ("STEP", SWITCH),
            ("JITTER", SWITCH),
            ("LINEAR_COMPOSITING", SWITCH),
            ("TRANSMITTANCE_ONLY", SWITCH),
            ("LANES", SWITCH),
        ],
        needs: &[("JITTER", &["STEP"]), ("LINEAR_COMPOSITING", &["STEP"]), ("LANES", &["STEP", "TF_2D"])],
        excludes: &[("LINEAR_COMPOSITING", "TRANSMITTANCE_ONLY")],
    },
];

impl Family {
    fn choices(&self) -> Vec<Choice> {
        self.own.iter().chain(&COMMON).copied().collect()
    }

    /// All variants that a scene can lead to.
    pub fn variants(&self) -> Vec<ProgramSpec> {
        let mut variants = vec![ProgramSpec::new(self.entry)];
        for (name, values) in self.choices() {
            variants = variants
                .iter()
                .flat_map(|spec| {
                    values.iter().map(|value| match *value {
                        "" => spec.clone(),
                        value => spec.clone().define(name, value),
                    })
                })
                .collect();
        }
        variants.retain(|spec| self.allows(spec));
        variants
    }

    /// Few variants in which every pair of choices that goes together stands at least once: the errors that
    /// specialisation can make are between two features, rarely between three.
    pub fn covering_variants(&self) -> Vec<ProgramSpec> {
        let all: Vec<(ProgramSpec, Vec<Pair>)> =
            self.variants().into_iter().map(|spec| (spec.clone(), self.pairs(&spec))).collect();
        let mut open: Vec<&Pair> = all.iter().flat_map(|(_, pairs)| pairs).collect();
        open.sort_unstable();
        open.dedup();
        let mut chosen = Vec::new();
        while !open.is_empty() {
            let news = |pairs: &[Pair]| pairs.iter().filter(|pair| open.binary_search(pair).is_ok()).count();
            let Some((spec, pairs)) = all.iter().max_by_key(|(_, pairs)| news(pairs)) else { break };
            open.retain(|pair| !pairs.contains(pair));
            chosen.push(spec.clone());
        }
        chosen
    }

    fn allows(&self, spec: &ProgramSpec) -> bool {
        let has = |name: &str| spec.defines.iter().any(|(defined, _)| *defined == name);
        self.needs.iter().all(|(name, others)| !has(name) || others.iter().any(|other| has(other)))
            && self.excludes.iter().all(|(a, b)| !(has(a) && has(b)))
    }

    fn pairs(&self, spec: &ProgramSpec) -> Vec<Pair> {
        let value = |name: &'static str| {
            let define = spec.defines.iter().find(|(defined, _)| *defined == name);
            (name, define.map_or(String::new(), |(_, value)| value.clone()))
        };
        let values: Vec<_> = self.choices().into_iter().map(|(name, _)| value(name)).collect();
        let later = |i: usize| values[i + 1..].iter().cloned();
        (0..values.len())
            .flat_map(|i| later(i).map(move |b| (i, b)))
            .map(|(i, b)| (values[i].clone(), b))
            .collect()
    }
}

/// Two choices of one variant.
type Pair = ((&'static str, String), (&'static str, String));

/// Whether `spec` (its definitions in any order) stands in the table.
pub fn is_listed(spec: &ProgramSpec) -> bool {
    let sorted = |spec: &ProgramSpec| {
        let mut defines = spec.defines.clone();
        defines.sort();
        defines
    };
    let wanted = sorted(spec);
    let families = FAMILIES.iter().filter(|family| family.entry == spec.entry);
    families.flat_map(Family::variants).any(|variant| sorted(&variant) == wanted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_the_variants_it_should() {
        // 5 voxel types × 2³; × (cell: 1-D 2, 2-D 2·lanes; step: 2·(linear 1 + exponential 2)·lanes, 1-D and 2-D).
        assert_eq!(FAMILIES.each_ref().map(|family| family.variants().len()), [40, 40, 40 * (2 + 4 + 24)]);
    }

    #[test]
    fn few_variants_cover_every_pair() {
        for family in &FAMILIES {
            let pairs = |variants: Vec<ProgramSpec>| {
                let mut pairs: Vec<Pair> = variants.iter().flat_map(|spec| family.pairs(spec)).collect();
                pairs.sort();
                pairs.dedup();
                pairs
            };
            let covering = family.covering_variants();
            assert!(covering.len() <= 16, "{}: {}", family.entry, covering.len());
            assert_eq!(pairs(covering), pairs(family.variants()));
        }
    }
}
