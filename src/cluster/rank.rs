//! A process that works for rank 0.

use super::word::{CONTROL, Hello, Identity, Order, Ready, Report};
use crate::crew;
use crate::device::{Device, DeviceInfo};
use crate::post::{Exchange, Letter, Line, Packet, Reader};
use crate::render::{BRICK_SHIFT, Plan, SceneData, Share, data_hash};
use crate::scene::Scene;
use crate::{Error, Result};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// How long orders are waited for until it is seen whether they can still come.
const PATIENCE: Duration = Duration::from_secs(1);

/// What such a process brings.
pub struct Rank<'a> {
    /// The machine it runs on.
    pub host: String,
    /// The scene that it has read, or why it could not.
    pub scene: Result<Scene>,
    /// The share of the picture's samples that is rendered, where it is not the whole.
    pub part: Option<Share>,
    /// The devices it may use, or why there are none.
    pub devices: Result<Vec<&'a DeviceInfo>>,
}

/// Works for rank 0 until that says that it is done, and with which exit code.
///
/// # Errors
/// [`Error::Failed`] when nobody carries letters any more.
pub fn serve(exchange: &Exchange, rank: &Rank<'_>) -> Result<u8> {
    let control = exchange.line(0, CONTROL);
    let scene = rank.scene.as_ref().map(|scene| Identity::of(scene, rank.part)).map_err(Error::to_string);
    tell(exchange, &Report::Hello(Hello { host: rank.host.clone(), scene }))?;
    let data = OnceLock::new();
    let mut order = next(exchange, &control)?;
    loop {
        order = match order {
            Order::End { code } => return Ok(code),
            Order::Close => next(exchange, &control)?,
            Order::View { index, port } => {
                let closing = Arc::new(AtomicBool::new(false));
                View { exchange, rank, data: &data, index, port, closing }.until_closed(&control)?
            }
        }
    }
}

fn tell(exchange: &Exchange, report: &Report) -> Result<()> {
    exchange.send(Letter { peer: 0, port: CONTROL, bytes: Packet::of(report).into_bytes() })
}

/// The next order. That this process knows of the end is said at once: its devices may be in the middle of a build.
fn next(exchange: &Exchange, control: &Line<'_>) -> Result<Order> {
    loop {
        let Some(bytes) = control.receive(PATIENCE)? else { continue };
        let order = Reader::new(&bytes).head()?;
        if let Order::End { .. } = order {
            tell(exchange, &Report::Bye)?;
        }
        return Ok(order);
    }
}

/// A view of the scene that is rendered.
struct View<'a> {
    exchange: &'a Exchange,
    rank: &'a Rank<'a>,
    /// The scene's data, once they are read.
    data: &'a OnceLock<SceneData>,
    index: usize,
    /// The line of the first device; those of others follow.
    port: u64,
    closing: Arc<AtomicBool>,
}

impl View<'_> {
    /// Works until rank 0 says that the view is done; what it says next.
    fn until_closed(&self, control: &Line<'_>) -> Result<Order> {
        std::thread::scope(|scope| {
            let work = scope.spawn(|| self.work());
            let mut order = next(self.exchange, control);
            self.closing.store(true, Ordering::Relaxed);
            if let Ok(Order::Close) = order {
                order = next(self.exchange, control);
            }
            work.join().unwrap_or_else(|_| Err(Error::Failed("its thread panicked".into()))).and(order)
        })
    }

    fn work(&self) -> Result<()> {
        match self.render() {
            // This machine cannot: others can.
            Err(Error::Failed(what)) => {
                self.refuse(Ok(String::new()), vec![format!("takes no part: {what}")])
            }
            Err(error) => self.refuse(Err(error.to_string()), Vec::new()),
            Ok(()) => Ok(()),
        }
    }

    fn refuse(&self, data: Result<String, String>, remarks: Vec<String>) -> Result<()> {
        tell(self.exchange, &Report::Ready(Ready { data, devices: Vec::new(), remarks }))
    }

    /// Says that it is ready, and works as long as there is work.
    ///
    /// # Errors
    /// What keeps it from being ready.
    fn render(&self) -> Result<()> {
        let rank = self.rank;
        // Rank 0 does not go on with a scene that is not there.
        let scene = rank.scene.as_ref().map_err(|error| Error::Input(error.to_string()))?;
        let devices = rank.devices.as_ref().map_err(|error| Error::Failed(error.to_string()))?;
        let scene = scene.of_view(scene.views.get(self.index).ok_or_else(no_view)?);
        let data = match self.data.get() {
            Some(data) => data,
            None => {
                let read = SceneData::load(&scene)?;
                self.data.get_or_init(|| read)
            }
        };
        let plan = Plan::new(&scene, data, BRICK_SHIFT)?.of_part(rank.part)?;
        let hash = data_hash(&plan, data)?;
        let (mut opened, mut remarks) = (Vec::new(), Vec::new());
        for info in devices {
            match Device::open(info) {
                Ok(device) => opened.push(device),
                Err(error) => remarks.push(format!("left out: {error}")),
            }
        }
        let names = opened.iter().map(|device| device.info().names()).collect();
        tell(self.exchange, &Report::Ready(Ready { data: Ok(hash), devices: names, remarks }))?;
        let plan = &plan;
        std::thread::scope(|scope| {
            for (port, device) in (self.port..).zip(opened) {
                let closing = Arc::clone(&self.closing);
                scope.spawn(move || crew::join(self.exchange.line(0, port), plan, device, closing));
            }
        });
        Ok(())
    }
}

fn no_view() -> Error {
    Error::Input("the scene has fewer views than that of rank 0".into())
}
