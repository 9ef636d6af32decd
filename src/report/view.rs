//! The results as the report shows them: groups of cases, and which cases can stand in for each other.

use std::path::Path;

use crate::bench::results::{Case, Finding, FindingKind, ReferenceKind, Results, Severity};

/// The results with what is derived from them.
pub struct View<'a> {
    /// What was found.
    pub results: &'a Results,
    /// The folder that their paths are relative to.
    pub folder: &'a Path,
    /// Cases in groups, in the order of their first ones; without those that are judged by a truth alone.
    pub groups: Vec<Group<'a>>,
}

/// Cases that are shown in one plot.
pub struct Group<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its cases.
    pub members: Vec<Member<'a>>,
}

/// A case in its group.
pub struct Member<'a> {
    /// Its place among the results.
    pub index: usize,
    /// Its colour in the plots: the first of a curve gives its place in the group to all of them.
    pub series: usize,
    /// The case.
    pub case: &'a Case,
    /// Its name, with the device where there are several.
    pub label: String,
}

impl<'a> View<'a> {
    /// Sorts the cases into groups.
    pub fn new(results: &'a Results, folder: &'a Path) -> Self {
        let mut groups: Vec<Group<'a>> = Vec::new();
        for (index, case) in results.cases.iter().enumerate().filter(|(_, case)| !case.is_only_truth()) {
            let place = groups.iter().position(|group| group.name == case.group).unwrap_or_else(|| {
                groups.push(Group { name: &case.group, members: Vec::new() });
                groups.len() - 1
            });
            let label = label(results, case);
            let members = &groups[place].members;
            let series =
                members.iter().find(|member| same_curve(member.case, case)).map(|first| first.series);
            let series = series.unwrap_or(members.len());
            groups[place].members.push(Member { index, series, case, label });
        }
        Self { results, folder, groups }
    }

    /// The name of a case, by its place among the results, with the device where there are several.
    pub fn label(&self, index: usize) -> String {
        label(self.results, &self.results.cases[index])
    }

    /// All cases, group by group.
    pub fn members(&self) -> impl Iterator<Item = &Member<'a>> {
        self.groups.iter().flat_map(|group| &group.members)
    }

    /// What was found about a case, or about its device.
    pub fn findings_of(&self, case: &Case) -> impl Iterator<Item = &'a Finding> {
        let (name, device) = (case.name.clone(), case.device.selector.clone());
        let all = self.results.findings.iter();
        all.filter(move |finding| {
            let same_case = finding.case.as_ref().is_none_or(|case| *case == name);
            let same_device = finding.device.as_ref().is_none_or(|selector| *selector == device);
            same_case && same_device && (finding.case.is_some() || finding.device.is_some())
        })
    }

    /// The worst that was found about a case.
    pub fn worst_of(&self, case: &Case) -> Option<Severity> {
        self.findings_of(case).map(|finding| finding.severity).min()
    }

    /// Whether there was a finding of this kind about a case.
    pub fn has(&self, case: &Case, kind: FindingKind) -> bool {
        self.findings_of(case).any(|finding| finding.kind == kind)
    }
}

impl<'a> Group<'a> {
    /// Cases by the curves that they are points of.
    pub fn curves(&self) -> Vec<Vec<&Member<'a>>> {
        let mut curves: Vec<Vec<&Member<'a>>> = Vec::new();
        for member in &self.members {
            match curves.iter_mut().find(|curve| same_curve(curve[0].case, member.case)) {
                Some(curve) => curve.push(member),
                None => curves.push(vec![member]),
            }
        }
        curves
    }

    /// Cases with one and the same reference: they show the same, and one can be had instead of another.
    pub fn targets(&self) -> Vec<Vec<&Member<'a>>> {
        let mut targets: Vec<Vec<&Member<'a>>> = Vec::new();
        for member in &self.members {
            match targets.iter_mut().find(|target| same_target(target[0].case, member.case)) {
                Some(target) => target.push(member),
                None => targets.push(vec![member]),
            }
        }
        targets
    }
}

fn label(results: &Results, case: &Case) -> String {
    let several = results.cases.iter().any(|other| other.device.selector != case.device.selector);
    if several { format!("{} on {}", case.name, case.device.selector) } else { case.name.clone() }
}

/// Whether two cases of a group are points of one curve.
fn same_curve(a: &Case, b: &Case) -> bool {
    a.curve.is_some() && a.curve == b.curve && a.device.selector == b.device.selector
}

/// One constant may be the truth of different scenes, a picture hardly.
fn same_target(a: &Case, b: &Case) -> bool {
    let (x, y) = (&a.reference, &b.reference);
    let same_scene = x.kind != ReferenceKind::Constant || a.scene == b.scene;
    let same_reference = match (&x.image, &y.image) {
        (Some(one), Some(other)) => one == other,
        _ => x.description == y.description && x.mean == y.mean,
    };
    same_reference && same_scene && (a.width, a.height) == (b.width, b.height)
}
