//! The validated suite: every case of the matrix with its scene.

use super::computed;
use super::results::SuiteInfo;
pub use super::spec::{
    CaseSpec, Checkpoints, ComputedReference, Gates, PublishedSpec, ReferenceSpec, RefusalSpec, Suite,
    TruthSpec,
};
use super::types::{
    CaseConfig, CheckpointsConfig, GatesConfig, PublishedConfig, ReferenceConfig, SuiteConfig, TruthConfig,
    VariantConfig,
};
use crate::config::{Document, Loaded, Problem, load_as, nearest, quote};
use crate::scene::{Image, Scene};
use crate::{Error, Result};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Seed of computed references: far from those of repeats, which count up from the suite's.
pub(super) const REFERENCE_SEED: u64 = 0x7265_6600_0000_0000;
/// Most cases of a suite; more are a mistake in `vary`.
const MOST_CASES: usize = 1000;

impl Suite {
    /// Reads and validates a suite with the scenes of all its cases.
    ///
    /// # Errors
    /// [`Error::Input`] with every problem rendered: those of the suite, or else those of the scenes.
    pub fn load(path: &Path) -> Result<Self> {
        Self::from_loaded(&load_as(path, "suite", &[])?, path)
    }

    /// Validates a suite that was read from `path`.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn from_loaded(loaded: &Loaded<SuiteConfig>, path: &Path) -> Result<Self> {
        let (config, document) = (&loaded.config, &loaded.document);
        let mut reader = Reader {
            document,
            folder: path.parent().unwrap_or(Path::new("")),
            suite: config,
            problems: Vec::new(),
        };
        let drafts = reader.drafts();
        let published = config.published.iter().map(published).collect::<Vec<_>>();
        reader.check_published(&published, &drafts);
        if !reader.problems.is_empty() {
            return Err(document.error(&reader.problems));
        }
        let text = document.sources.first().map_or("", |source| source.text.as_str());
        let mut errors: Vec<f64> = config.errors.iter().map(|error| error.0).collect();
        errors.sort_by(|a, b| b.total_cmp(a));
        let (refused, drafts): (Vec<_>, Vec<_>) =
            drafts.into_iter().partition(|draft| draft.refuses.is_some());
        Ok(Self {
            info: SuiteInfo {
                title: config.title.clone(),
                about: config.about.clone(),
                file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                hash: short_hash(text.as_bytes()),
            },
            devices: config.devices.clone(),
            seed: config.seed,
            cases: finish_all(drafts)?,
            refusals: refused.into_iter().filter_map(refusal).collect(),
            errors,
            slower: config.slower.0,
            published,
        })
    }

    /// Keeps the cases whose names contain one of `texts`, if there are any.
    ///
    /// # Errors
    /// [`Error::Input`] when a text is in no name.
    pub fn keep(&mut self, texts: &[String]) -> Result<()> {
        let names = || {
            let refusals = self.refusals.iter().map(|case| &case.name);
            self.cases.iter().map(|case| &case.name).chain(refusals)
        };
        if let Some(text) = texts.iter().find(|text| !names().any(|name| name.contains(*text))) {
            let meant = nearest(text, names().map(String::as_str));
            let hint = meant.map_or(String::new(), |name| format!("; did you mean {}?", quote(name)));
            return Err(Error::Input(format!("no case has {} in its name{hint}", quote(text))));
        }
        let kept = |name: &str| texts.is_empty() || texts.iter().any(|text| name.contains(text));
        self.cases.retain(|case| kept(&case.name));
        self.refusals.retain(|case| kept(&case.name));
        Ok(())
    }
}

/// The first 16 bytes of the SHA-256, in hexadecimal.
pub(super) fn short_hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().take(16).fold(String::new(), |mut hex, byte| {
        let _ = write!(hex, "{byte:02x}");
        hex
    })
}

/// A case whose scene is not read yet.
struct Draft<'c> {
    name: String,
    group: String,
    config: &'c CaseConfig,
    scene_path: PathBuf,
    overrides: Vec<String>,
    repeats: u32,
    warmup: u32,
    checkpoints: Checkpoints,
    /// `None` where the truth is all there is.
    reference: Option<&'c ReferenceConfig>,
    /// Where the suite is.
    folder: &'c Path,
    gates: Gates,
    truth: Option<&'c TruthConfig>,
    refuses: Option<&'c String>,
    limit: Option<Duration>,
}

struct Reader<'c> {
    document: &'c Document,
    folder: &'c Path,
    suite: &'c SuiteConfig,
    problems: Vec<Problem>,
}

impl<'c> Reader<'c> {
    fn wrong(&mut self, path: &str, message: String, label: &str) {
        let problem = Problem::new(message, self.document.spot(path));
        self.problems.push(problem.label(label));
    }

    /// The value at `key` of case `index` if it was given there, else of the suite: its path and value.
    fn of_case<T>(index: usize, key: &str, own: Option<&'c T>, suite: &'c T) -> (String, &'c T) {
        match own {
            Some(own) => (format!("case.{index}.{key}"), own),
            None => (key.to_owned(), suite),
        }
    }

    fn drafts(&mut self) -> Vec<Draft<'c>> {
        if self.suite.case.is_empty() {
            self.wrong("case", "the suite has no case".into(), "needs at least one [[case]]");
        }
        let mut drafts = Vec::new();
        for (index, case) in self.suite.case.iter().enumerate() {
            drafts.extend(self.drafts_of(index, case));
            if drafts.len() > MOST_CASES {
                let message = format!("the suite has more than {MOST_CASES} cases");
                self.wrong(&format!("case.{index}.vary"), message, "too many combinations");
                return drafts;
            }
        }
        self.check_names(&drafts);
        drafts
    }

    fn drafts_of(&mut self, index: usize, case: &'c CaseConfig) -> Vec<Draft<'c>> {
        let at = |key: &str| format!("case.{index}.{key}");
        let scene_path = self.file(&at("scene"), &case.scene);
        let (path, vary) = Self::of_case(index, "vary", case.vary.as_ref(), &self.suite.vary);
        for (axis, variants) in vary.iter().enumerate() {
            if variants.is_empty() {
                self.wrong(
                    &format!("{path}.{axis}"),
                    "an axis without variants".into(),
                    "needs at least one",
                );
            }
            for (number, reference) in
                variants.iter().enumerate().filter_map(|(n, v)| Some((n, v.reference.as_ref()?)))
            {
                self.reference_file(&format!("{path}.{axis}.{number}.reference"), reference);
            }
        }
        let (path, checkpoints) =
            Self::of_case(index, "checkpoints", case.checkpoints.as_ref(), &self.suite.checkpoints);
        let checkpoints = self.checkpoints(&path, checkpoints);
        let (path, own_reference) =
            Self::of_case(index, "reference", case.reference.as_ref(), &self.suite.reference);
        self.reference_file(&path, own_reference);
        let gates = gates(case.gates.as_ref().unwrap_or(&self.suite.gates));
        let group = case.group.as_ref().unwrap_or(&case.name);
        let folder = self.folder;
        let limit = case.limit.or(self.suite.limit).map(|limit| limit.0);
        let draft = |combination: Vec<&'c VariantConfig>| {
            let variants = || combination.iter().rev();
            let truth = variants().find_map(|variant| variant.truth.as_ref()).or(case.truth.as_ref());
            let of_variant = variants().find_map(|variant| variant.reference.as_ref());
            // A truth stands in for the suite's reference, not for one that was given to the case.
            let own = (truth.is_none() || case.reference.is_some()).then_some(own_reference);
            Draft {
                reference: of_variant.or(own),
                truth,
                refuses: variants().find_map(|variant| variant.refuses.as_ref()).or(case.refuses.as_ref()),
                limit,
                name: combination.iter().fold(case.name.clone(), |name, variant| name + ", " + &variant.name),
                group: match combination
                    .iter()
                    .filter_map(|variant| variant.group.as_deref())
                    .collect::<Vec<_>>()
                {
                    none if none.is_empty() => group.clone(),
                    names => names.join(", "),
                },
                config: case,
                scene_path: scene_path.clone(),
                overrides: [&self.suite.set, &case.set]
                    .into_iter()
                    .chain(combination.iter().map(|variant| &variant.set))
                    .flatten()
                    .cloned()
                    .collect(),
                repeats: case.repeats.unwrap_or(self.suite.repeats),
                warmup: case.warmup.unwrap_or(self.suite.warmup),
                checkpoints: checkpoints.clone(),
                folder,
                gates,
            }
        };
        combinations(vary).into_iter().map(draft).collect()
    }

    fn check_names(&mut self, drafts: &[Draft<'_>]) {
        let mut seen = BTreeMap::new();
        for draft in drafts {
            if draft.name.trim().is_empty() || draft.name.contains(char::is_control) {
                let index = self.suite.case.iter().position(|case| std::ptr::eq(case, draft.config));
                let path = format!("case.{}.name", index.unwrap_or(0));
                let message = format!("a case cannot be called {}", quote(&draft.name));
                self.wrong(&path, message, "needs at least one letter, and all on one line");
            }
            if seen.insert(&draft.name, ()).is_some() {
                let index = self.suite.case.iter().rposition(|case| std::ptr::eq(case, draft.config));
                let path = format!("case.{}.name", index.unwrap_or(0));
                let message = format!("two cases are called {}", quote(&draft.name));
                self.wrong(&path, message, "names of cases must differ");
            }
        }
    }

    /// Reports a reference in a file that is not there.
    fn reference_file(&mut self, path: &str, reference: &ReferenceConfig) {
        if let ReferenceConfig::File { path: name } = reference {
            self.file(&format!("{path}.path"), name);
        }
    }

    fn file(&mut self, path: &str, name: &str) -> PathBuf {
        let file = self.folder.join(name);
        if !file.is_file() {
            let label = format!("looked for {}", file.display());
            self.wrong(path, format!("there is no file {}", quote(name)), &label);
        }
        file
    }

    fn checkpoints(&mut self, path: &str, config: &CheckpointsConfig) -> Checkpoints {
        let ascending = |values: &[u128]| !values.is_empty() && values.is_sorted_by(|a, b| a < b);
        let checkpoints = match (&config.samples, &config.times) {
            (Some(_), Some(_)) => {
                self.wrong(path, "checkpoints are samples or times".into(), "give one of the two");
                return Checkpoints::Samples(vec![1]);
            }
            (None, Some(times)) => Checkpoints::Times(times.iter().map(|time| time.0).collect()),
            (Some(samples), None) => Checkpoints::Samples(samples.clone()),
            (None, None) => Checkpoints::Samples(vec![1, 4, 16, 64]),
        };
        let (key, fine) = match &checkpoints {
            Checkpoints::Samples(samples) => {
                ("samples", ascending(&samples.iter().map(|&n| u128::from(n)).collect::<Vec<_>>()))
            }
            Checkpoints::Times(times) => {
                ("times", ascending(&times.iter().map(Duration::as_nanos).collect::<Vec<_>>()))
            }
        };
        if !fine || matches!(&checkpoints, Checkpoints::Samples(samples) if samples[0] == 0) {
            let path = format!("{path}.{key}");
            self.wrong(&path, format!("`{path}` must ascend"), "at least one, each more than the one before");
        }
        checkpoints
    }

    fn check_published(&mut self, published: &[PublishedSpec], drafts: &[Draft<'_>]) {
        let names = || drafts.iter().map(|draft| draft.name.as_str());
        for (index, entry) in published.iter().enumerate() {
            if names().any(|name| name == entry.case) {
                continue;
            }
            let label = match nearest(&entry.case, names()) {
                Some(meant) => format!("did you mean {}?", quote(meant)),
                None => "must be the whole name of a case, variants included".into(),
            };
            let message = format!("there is no case {}", quote(&entry.case));
            self.wrong(&format!("published.{index}.case"), message, &label);
        }
    }
}

/// Every choice of one variant per axis, the last axis running fastest; one empty choice without axes.
fn combinations(axes: &[Vec<VariantConfig>]) -> Vec<Vec<&VariantConfig>> {
    let mut all = vec![Vec::new()];
    for axis in axes {
        let longer = |chosen: &Vec<_>| {
            axis.iter().map(|variant| [&chosen[..], &[variant]].concat()).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).take(MOST_CASES + 1).collect();
    }
    all
}

/// Reads the scenes; the texts of all that are wrong together, each once.
fn finish_all(drafts: Vec<Draft<'_>>) -> Result<Vec<CaseSpec>> {
    let mut cases = Vec::new();
    let mut wrong: Vec<(String, String)> = Vec::new();
    for draft in drafts {
        let name = draft.name.clone();
        match finish(draft) {
            Ok(case) => cases.push(case),
            Err(error) => {
                let text = error.to_string();
                if wrong.iter().all(|(_, known)| *known != text) {
                    wrong.push((name, text));
                }
            }
        }
    }
    if wrong.is_empty() {
        return Ok(cases);
    }
    let texts: Vec<String> =
        wrong.iter().map(|(name, text)| format!("{text}, in case {}", quote(name))).collect();
    Err(Error::Input(texts.join("\n\n")))
}

fn finish(draft: Draft<'_>) -> Result<CaseSpec> {
    let scene = Scene::load(&draft.scene_path, &draft.overrides)?;
    let truth = draft.truth.map(|truth| truth_of(truth, &scene.image)).transpose()?;
    let reference = match draft.reference {
        None => ReferenceSpec::Truth(truth.as_ref().map_or([0.0; 3], |truth| truth.value)),
        Some(ReferenceConfig::Constant { value }) => ReferenceSpec::Constant(value.0),
        Some(ReferenceConfig::File { path: name }) => {
            ReferenceSpec::File { name: name.clone(), path: draft.folder.join(name) }
        }
        Some(ReferenceConfig::Computed { set, error, time }) => {
            let sets: Vec<String> = draft.overrides.iter().chain(set).cloned().collect();
            let scenes = computed::scenes(&draft.scene_path, &sets, REFERENCE_SEED)?;
            let (image, of_case) = (&scenes[0].image, &scene.image);
            if (image.width, image.height) != (of_case.width, of_case.height) {
                return Err(Error::Input(format!(
                    "error: the reference has {}×{} pixels, its case {}×{}; they must be of one size",
                    image.width, image.height, of_case.width, of_case.height
                )));
            }
            ReferenceSpec::Computed(Box::new(ComputedReference {
                scenes,
                overrides: set.clone(),
                error: error.0,
                time: time.map(|limit| limit.0),
            }))
        }
    };
    Ok(CaseSpec {
        name: draft.name,
        about: draft.config.about.clone(),
        group: draft.group,
        curve: draft.config.curve.clone(),
        scene_name: draft.config.scene.clone(),
        scene_path: draft.scene_path,
        overrides: draft.overrides,
        scene,
        repeats: draft.repeats,
        warmup: draft.warmup,
        checkpoints: draft.checkpoints,
        reference,
        gates: draft.gates,
        truth,
        limit: draft.limit,
    })
}

fn truth_of(config: &TruthConfig, image: &Image) -> Result<TruthSpec> {
    let region = config.region.unwrap_or([0, 0, image.width, image.height]);
    let [left, top, right, bottom] = region;
    if left >= right || top >= bottom || right > image.width || bottom > image.height {
        return Err(Error::Input(format!(
            "error: the region {region:?} of the truth is not in the image of {}×{} pixels; it must be \
             [left, top, right, bottom] with left < right ≤ {0} and top < bottom ≤ {1}",
            image.width, image.height
        )));
    }
    let TruthConfig { value, of, error, sigmas, ref source, tolerance, .. } = *config;
    let (value, tolerance, source) = (value.0, tolerance.0, source.clone());
    Ok(TruthSpec { value, of, region, error, tolerance, sigmas, source })
}

fn refusal(draft: Draft<'_>) -> Option<RefusalSpec> {
    Some(RefusalSpec {
        message: draft.refuses?.clone(),
        name: draft.name,
        about: draft.config.about.clone(),
        group: draft.group,
        scene_name: draft.config.scene.clone(),
        scene_path: draft.scene_path,
        overrides: draft.overrides,
    })
}

fn gates(config: &GatesConfig) -> Gates {
    Gates {
        max_relative_rmse: config.max_relative_rmse.map(|error| error.0),
        max_bias_z: config.max_bias_z,
        max_relative_bias: config.max_relative_bias.map(|error| error.0),
        max_slope: config.max_slope,
        min_psnr: config.min_psnr,
    }
}

fn published(config: &PublishedConfig) -> PublishedSpec {
    let PublishedConfig { source, label, case, measure, value, unit, note } = config.clone();
    PublishedSpec { source, label, case, measure, value, unit, note }
}
