//! Every variant of every program: what `-D` definitions a scene can lead to.
//!
//! A method that gains a feature gains it here, so that the tests build it on every device. A test also checks that
//! the programs of real plans stand in this table. The variants of a kernel are far too many to list; they are given by
//! choices, and by rules about which go together.

use crate::device::ProgramSpec;

/// What is chosen for a program, one of several options: each is a set of definitions.
#[derive(Clone, Copy)]
enum Choice {
    /// A feature that is compiled in or not.
    Switch(&'static str),
    /// A definition that always stands, with one of these values.
    Value(&'static str, &'static [&'static str]),
    /// Anything else.
    Sets(&'static [&'static [Define]]),
}

/// A name and its value.
type Define = (&'static str, &'static str);

/// What every program of a volume needs.
const VOLUME: [Choice; 1] = [Choice::Value("VOXEL", &["uchar", "char", "ushort", "short", "float"])];

/// What every program may need.
const COMMON: [Choice; 3] =
    [Choice::Switch("FILTER_BOX"), Choice::Switch("THIN_LENS"), Choice::Switch("ENVIRONMENT")];

/// The variants of one kernel.
pub struct Family {
    /// Path below `cl/`.
    pub entry: &'static str,
    /// The kernel.
    pub kernel: &'static str,
    volume: &'static [Choice],
    own: &'static [Choice],
    /// Definitions that need another one, any of those named.
    needs: &'static [(&'static str, &'static [&'static str])],
    /// Pairs of definitions that exclude each other.
    excludes: &'static [(&'static str, &'static str)],
}

/// All kernels that render.
pub const FAMILIES: [Family; 6] = [
    Family {
        entry: "render/mip.cl",
        kernel: "render_mip",
        volume: &VOLUME,
        own: &[],
        needs: &[],
        excludes: &[],
    },
    Family {
        entry: "render/isosurface.cl",
        kernel: "render_isosurface",
        volume: &VOLUME,
        own: &[],
        needs: &[],
        excludes: &[],
    },
    Family {
        entry: "render/emission_absorption.cl",
        kernel: "render_emission_absorption",
        volume: &VOLUME,
        own: &[
            Choice::Switch("TF_2D"),
            Choice::Switch("STEP"),
            Choice::Switch("JITTER"),
            Choice::Switch("LINEAR_COMPOSITING"),
            Choice::Switch("TRANSMITTANCE_ONLY"),
            Choice::Switch("LANES"),
        ],
        needs: &[("JITTER", &["STEP"]), ("LINEAR_COMPOSITING", &["STEP"]), ("LANES", &["STEP", "TF_2D"])],
        excludes: &[("LINEAR_COMPOSITING", "TRANSMITTANCE_ONLY")],
    },
    Family {
        entry: "render/scattering.cl",
        kernel: "render_scattering",
        volume: &VOLUME,
        own: &[
            // Lanes of CPUs take a tile per work-item.
            Choice::Sets(&[
                &[("WIDTH", "1")],
                &[("WIDTH", "4"), ("PIXELS", "64")],
                &[("WIDTH", "8"), ("PIXELS", "64")],
                &[("WIDTH", "16"), ("PIXELS", "64")],
            ]),
            // The extinction: from the table, a line, one number that is looked up, or one that is not.
            Choice::Sets(&[
                &[],
                &[("SIGMA_RAMP", "1")],
                &[("CONSTANT_SIGMA", "1")],
                &[("CONSTANT_SIGMA", "1"), ("CLOSED_FORM", "1")],
            ]),
            Choice::Sets(&[
                &[("PHASE_ISOTROPIC", "1")],
                &[("PHASE_HG", "1")],
                &[("PHASE_RAYLEIGH", "1")],
                &[("PHASE_TWO_LOBE", "1")],
            ]),
            // Estimates of the transmittance apart from the collisions.
            Choice::Sets(&[&[], &[("TRANSMITTANCE_RESIDUAL", "1")], &[("TRANSMITTANCE_MARCHING", "1")]]),
            Choice::Switch("TF_2D"),
            Choice::Switch("CONSTANT_ALBEDO"),
            Choice::Switch("CHROMATIC"),
            Choice::Switch("EMISSION"),
            Choice::Switch("GREY"),
            Choice::Switch("SAMPLE_LIGHTS"),
            Choice::Switch("EQUIANGULAR"),
            Choice::Switch("RECTANGLES"),
            Choice::Switch("AUXILIARY"),
        ],
        needs: &[
            ("CONSTANT_SIGMA", &["CONSTANT_ALBEDO"]),
            ("RECTANGLES", &["SAMPLE_LIGHTS"]),
            ("EQUIANGULAR", &["SAMPLE_LIGHTS"]),
        ],
        excludes: &[
            ("SIGMA_RAMP", "TF_2D"),
            ("CONSTANT_SIGMA", "EMISSION"),
            ("CONSTANT_SIGMA", "TRANSMITTANCE_RESIDUAL"),
            ("CONSTANT_SIGMA", "TRANSMITTANCE_MARCHING"),
            ("GREY", "CHROMATIC"),
            ("GREY", "ENVIRONMENT"),
        ],
    },
    Family {
        entry: "render/light_volume.cl",
        kernel: "render_light_volume",
        volume: &VOLUME,
        own: &[
            Choice::Sets(&[
                &[("PHASE_ISOTROPIC", "1")],
                &[("PHASE_HG", "1"), ("DIRECTED", "1")],
                &[("PHASE_RAYLEIGH", "1"), ("DIRECTED", "1")],
                &[("PHASE_TWO_LOBE", "1"), ("DIRECTED", "1")],
            ]),
            Choice::Switch("TF_2D"),
            Choice::Switch("CHROMATIC"),
            Choice::Switch("EMISSION"),
        ],
        needs: &[],
        excludes: &[],
    },
    Family {
        entry: "render/caustics.cl",
        kernel: "render_caustics",
        volume: &[],
        own: &[
            Choice::Sets(&[
                &[("MAP_BRUTE_FORCE", "1")],
                &[("MAP_LEXICOGRAPHIC", "1")],
                &[("MAP_VOXELS", "1")],
                &[("MAP_PLANAR", "1")],
            ]),
            Choice::Sets(&[
                &[("KERNEL_CONSTANT", "1")],
                &[("KERNEL_CONE", "1")],
                &[("KERNEL_SMOOTHSTEP", "1")],
            ]),
            Choice::Switch("EDGE_CORRECTION"),
            Choice::Switch("GATHER_LANES"),
            Choice::Switch("SHAPE_PLANE"),
            Choice::Switch("SHAPE_SPHERE"),
            Choice::Switch("SHAPE_RECTANGLE"),
            Choice::Switch("SHAPE_DISK"),
            Choice::Switch("SHAPE_BOX"),
            Choice::Switch("SHAPE_METABALLS"),
            Choice::Switch("SHAPE_TRIANGLE"),
            Choice::Switch("SHAPE_SMOOTH"),
            Choice::Switch("DISPERSION"),
            Choice::Switch("RECTANGLES"),
            Choice::Switch("DIRECT_RAYS"),
            Choice::Switch("BOUNCED"),
            Choice::Switch("BEGINS_WITHIN"),
            // A volume between the surfaces.
            Choice::Sets(&[
                &[],
                &[("MEDIUM", "1"), ("WIDTH", "1"), ("PHASE_ISOTROPIC", "1")],
                &[("MEDIUM", "1"), ("WIDTH", "1"), ("PHASE_HG", "1")],
                &[("MEDIUM", "1"), ("WIDTH", "1"), ("PHASE_RAYLEIGH", "1")],
                &[("MEDIUM", "1"), ("WIDTH", "1"), ("PHASE_TWO_LOBE", "1")],
            ]),
            Choice::Sets(&[
                &[],
                &[("VOXEL", "uchar")],
                &[("VOXEL", "char")],
                &[("VOXEL", "ushort")],
                &[("VOXEL", "short")],
                &[("VOXEL", "float")],
            ]),
            Choice::Sets(&[
                &[],
                &[("TRANSMITTANCE_RESIDUAL", "1")],
                &[("TRANSMITTANCE_RESIDUAL", "1"), ("SIGMA_RAMP", "1")],
                &[("CONSTANT_SIGMA", "1")],
            ]),
            Choice::Switch("TF_2D"),
            Choice::Switch("CONSTANT_ALBEDO"),
        ],
        needs: &[
            ("SHAPE_SMOOTH", &["SHAPE_TRIANGLE"]),
            ("MEDIUM", &["VOXEL"]),
            ("MEDIUM", &["TRANSMITTANCE_RESIDUAL", "CONSTANT_SIGMA"]),
            ("TRANSMITTANCE_RESIDUAL", &["MEDIUM"]),
            ("VOXEL", &["MEDIUM"]),
            ("SIGMA_RAMP", &["MEDIUM"]),
            ("CONSTANT_SIGMA", &["MEDIUM"]),
            ("CONSTANT_SIGMA", &["CONSTANT_ALBEDO"]),
            ("TF_2D", &["MEDIUM"]),
            ("CONSTANT_ALBEDO", &["MEDIUM"]),
        ],
        excludes: &[("MEDIUM", "MAP_PLANAR"), ("SIGMA_RAMP", "TF_2D")],
    },
];

impl Choice {
    /// The definitions of every option.
    fn options(self) -> Vec<Vec<Define>> {
        match self {
            Self::Switch(name) => vec![vec![], vec![(name, "1")]],
            Self::Value(name, values) => values.iter().map(|&value| vec![(name, value)]).collect(),
            Self::Sets(sets) => sets.iter().map(|set| set.to_vec()).collect(),
        }
    }
}

/// An option taken in each of the first choices; `None` where it is still open.
type Taken = Vec<Option<usize>>;

/// Two options that stand together: numbers of choices, the first smaller, and of their options.
type Pair = [(usize, usize); 2];

impl Family {
    fn choices(&self) -> Vec<Vec<Vec<Define>>> {
        self.own.iter().chain(self.volume).chain(&COMMON).map(|choice| choice.options()).collect()
    }

    /// Few variants in which every two options that can stand together do so at least once: the errors that
    /// specialisation can make are between two features, rarely between three.
    ///
    /// Each variant starts with a pair that no earlier one has, and takes, choice by choice, what brings most more.
    pub fn covering_variants(&self) -> Vec<ProgramSpec> {
        let choices = self.choices();
        let mut open = self.pairs();
        let mut chosen = Vec::new();
        while let Some(&first) = open.first() {
            let mut taken: Taken = vec![None; choices.len()];
            first.iter().for_each(|&(choice, option)| taken[choice] = Some(option));
            let gain = |taken: &Taken| open.iter().filter(|pair| stands_in(pair, taken)).count();
            while taken.contains(&None) {
                // The choice and option that bring most; of equals the first, so that the list is always the same.
                let candidates = (0..choices.len())
                    .filter(|&choice| taken[choice].is_none())
                    .flat_map(|choice| (0..choices[choice].len()).map(move |option| (choice, option)));
                let mut best: Option<(usize, Taken)> = None;
                for (choice, option) in candidates {
                    let mut with = taken.clone();
                    with[choice] = Some(option);
                    let gain = gain(&with);
                    if best.as_ref().is_none_or(|(most, _)| gain > *most)
                        && self.completes(&choices, &mut with.clone())
                    {
                        best = Some((gain, with));
                    }
                }
                let Some((_, with)) = best else { break };
                taken = with;
            }
            open.retain(|pair| !stands_in(pair, &taken));
            chosen.push(self.spec(&choices, &taken));
        }
        chosen
    }

    /// All pairs of options that can stand together, but not those of two choices with more than two options each:
    /// they would be most of the builds. Such options stand together as it happens.
    fn pairs(&self) -> Vec<Pair> {
        let choices = self.choices();
        let mut pairs = Vec::new();
        for (b, options) in choices.iter().enumerate() {
            for (a, others) in choices[..b].iter().enumerate() {
                if others.len() > 2 && options.len() > 2 {
                    continue;
                }
                let both = (0..others.len()).flat_map(|i| (0..options.len()).map(move |j| [(a, i), (b, j)]));
                pairs.extend(both.filter(|pair| {
                    let mut taken: Taken = vec![None; choices.len()];
                    pair.iter().for_each(|&(choice, option)| taken[choice] = Some(option));
                    self.completes(&choices, &mut taken)
                }));
            }
        }
        pairs
    }

    /// Whether the open choices can be taken so that the rules hold; takes them.
    fn completes(&self, choices: &[Vec<Vec<Define>>], taken: &mut Taken) -> bool {
        let still = choices.iter().zip(&*taken).filter(|(_, option)| option.is_none());
        let still: Vec<&str> =
            still.flat_map(|(options, _)| options.iter().flatten().map(|(name, _)| *name)).collect();
        if !self.allows(&names(choices, taken), &still) {
            return false;
        }
        let Some(open) = taken.iter().position(Option::is_none) else { return true };
        for option in 0..choices[open].len() {
            taken[open] = Some(option);
            if self.completes(choices, taken) {
                return true;
            }
        }
        taken[open] = None;
        false
    }

    /// Whether definitions of these names go together, when those of `still` may come to them.
    fn allows(&self, names: &[&str], still: &[&str]) -> bool {
        let has = |name: &&str| names.contains(name);
        let comes = |name: &&str| has(name) || still.contains(name);
        self.excludes.iter().all(|(a, b)| !(has(a) && has(b)))
            && self.needs.iter().all(|(name, others)| !has(name) || others.iter().any(comes))
    }

    fn spec(&self, choices: &[Vec<Vec<Define>>], taken: &Taken) -> ProgramSpec {
        let options = choices.iter().zip(taken).flat_map(|(options, &option)| &options[option.unwrap_or(0)]);
        options.fold(ProgramSpec::new(self.entry), |spec, &(name, value)| spec.define(name, value))
    }

    /// Whether each choice of the family is made once by these definitions, nothing is left over, and the rules hold.
    fn lists(&self, spec: &ProgramSpec) -> bool {
        let mut left: Vec<(&str, &str)> =
            spec.defines.iter().map(|(name, value)| (*name, value.as_str())).collect();
        let names: Vec<&str> = left.iter().map(|(name, _)| *name).collect();
        for options in self.choices() {
            let of_choice = |name: &str| options.iter().flatten().any(|(known, _)| *known == name);
            let (mut mine, rest): (Vec<_>, Vec<_>) = left.into_iter().partition(|(name, _)| of_choice(name));
            left = rest;
            mine.sort_unstable();
            let stands = options.iter().any(|option| {
                let mut option = option.clone();
                option.sort_unstable();
                option == mine
            });
            if !stands {
                return false;
            }
        }
        left.is_empty() && self.allows(&names, &[])
    }
}

fn stands_in(pair: &Pair, taken: &Taken) -> bool {
    pair.iter().all(|&(choice, option)| taken[choice] == Some(option))
}

/// The names that the options taken so far define.
fn names(choices: &[Vec<Vec<Define>>], taken: &Taken) -> Vec<&'static str> {
    let options = choices.iter().zip(taken).filter_map(|(options, &option)| Some(&options[option?]));
    options.flatten().map(|(name, _)| *name).collect()
}

/// Whether `spec` (its definitions in any order) stands in the table.
pub fn is_listed(spec: &ProgramSpec) -> bool {
    FAMILIES.iter().any(|family| family.entry == spec.entry && family.lists(spec))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All variants, for families small enough.
    fn all(family: &Family) -> Vec<ProgramSpec> {
        let choices = family.choices();
        let mut all: Vec<Taken> = vec![vec![]];
        for options in &choices {
            let with = |taken: Taken| {
                (0..options.len())
                    .map(move |option| [&taken[..], &[Some(option)]].concat())
                    .collect::<Vec<_>>()
            };
            all = all.into_iter().flat_map(with).collect();
        }
        all.iter().map(|taken| family.spec(&choices, taken)).filter(|spec| family.lists(spec)).collect()
    }

    #[test]
    fn the_table_has_the_variants_it_should() {
        // 5 voxel types × 2³. Emission-absorption has 2 variants per cell and 2·(linear 1 + exponential 2) by steps;
        // in lanes or not, except per cell with a 1-D function.
        let one_d = 2 + 2 * 6;
        let two_d = 2 * (2 + 6);
        let counts: Vec<usize> = FAMILIES[..3].iter().map(|family| all(family).len()).collect();
        assert_eq!(counts, [40, 40, 40 * (one_d + two_d)]);
    }

    #[test]
    fn definitions_stand_in_the_table_by_its_rules() {
        let base = ProgramSpec::new("render/scattering.cl").define("VOXEL", "float").define("PHASE_HG", 1);
        let one = base.clone().define("WIDTH", 1);
        assert!(is_listed(&one));
        assert!(is_listed(&base.clone().define("PIXELS", 64).define("WIDTH", 8).define("GREY", 1)));
        assert!(is_listed(&one.clone().define("RECTANGLES", 1).define("SAMPLE_LIGHTS", 1)));
        let wrong = [
            base.clone(),
            base.clone().define("WIDTH", 8),
            base.define("WIDTH", 2),
            one.clone().define("PHASE_RAYLEIGH", 1),
            one.clone().define("CLOSED_FORM", 1),
            one.clone().define("GREY", 2),
            one.clone().define("GREY", 1).define("CHROMATIC", 1),
            one.clone().define("RECTANGLES", 1),
            one.clone().define("UNHEARD_OF", 1),
            one.define("VOXEL", "char"),
            ProgramSpec::new("render/none.cl"),
        ];
        for spec in wrong {
            assert!(!is_listed(&spec), "{}", spec.options());
        }
    }

    #[test]
    fn few_variants_cover_every_pair() {
        // The five voxel types with any other feature alone take 10, with or without in caustics; four maps and three
        // kernels of photons 12.
        for (family, most) in FAMILIES.iter().zip([10, 10, 14, 16, 12, 20]) {
            let covering = family.covering_variants();
            assert!(covering.iter().all(|spec| family.lists(spec)));
            assert!(covering.len() <= most, "{}: {}", family.entry, covering.len());
            let choices = family.choices();
            for pair in family.pairs() {
                let defines = pair.map(|(choice, option)| &choices[choice][option]);
                let names = pair.map(|(choice, _)| choices[choice].iter().flatten().map(|(name, _)| *name));
                let names: Vec<&str> = names.into_iter().flatten().collect();
                let stands = |spec: &&ProgramSpec| {
                    let mine = spec.defines.iter().filter(|(name, _)| names.contains(name));
                    let mut mine: Vec<(&str, &str)> =
                        mine.map(|(name, value)| (*name, value.as_str())).collect();
                    let mut wanted: Vec<(&str, &str)> = defines.into_iter().flatten().copied().collect();
                    mine.sort_unstable();
                    wanted.sort_unstable();
                    mine == wanted
                };
                assert_eq!(covering.iter().filter(stands).count().min(1), 1, "{defines:?}");
            }
        }
    }

    #[test]
    fn pairs_that_the_rules_forbid_are_none() {
        let family = &FAMILIES[3];
        let choices = family.choices();
        let defined =
            |(choice, option): (usize, usize)| choices[choice][option].iter().map(|(name, _)| *name);
        let stands = |a: &str, b: &str| {
            let both = |pair: &Pair| {
                let [x, y] = pair.map(|end| defined(end).collect::<Vec<_>>());
                x.contains(&a) && y.contains(&b) || x.contains(&b) && y.contains(&a)
            };
            family.pairs().iter().any(both)
        };
        assert!(stands("RECTANGLES", "GREY"));
        assert!(!stands("EMISSION", "CONSTANT_SIGMA"));
        assert!(!stands("TF_2D", "SIGMA_RAMP"));
        // What an option needs rules out the option without it.
        let [a, b] = ["SAMPLE_LIGHTS", "RECTANGLES"].map(|name| {
            choices.iter().position(|options| options[1..].iter().flatten().any(|(n, _)| *n == name))
        });
        let pair = [(a.unwrap(), 0), (b.unwrap(), 1)];
        assert!(!family.pairs().contains(&pair));
    }
}
