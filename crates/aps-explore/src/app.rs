//! The addresses of the server.

use std::sync::Arc;
use std::time::Duration;

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::RepairReport;
use http_body_util::{BodyExt, LengthLimitError, Limited};
use hyper::body::{Body, Bytes, Incoming};
use hyper::header::CONTENT_TYPE;
use hyper::http::request;
use hyper::{Method, Request};
use map2aps::sampling;
use rayon::ThreadPoolBuildError;
use serde::{Serialize, de::DeserializeOwned};
use serde_json::json;
use tokio::sync::mpsc;

use crate::cache::Cache;
use crate::compare::compare;
use crate::coverage::Survey;
use crate::fault::Fault;
use crate::link::answer;
use crate::reply::{self, Parts, Reply};
use crate::request::{CityQuestion, CoverageQuestion, LinkQuestion, read};
use crate::request_handle::{Held, LatestRequests, RequestHandle};
use crate::workers::Workers;
use crate::{files, guard, page};

/// Largest body \[bytes\]: the drawn houses of a map are some ten kilobytes.
const MAX_BODY: usize = 1 << 18;

/// Time for a body to arrive \[s\].
const BODY_S: u64 = 10;

/// Places of each kind of terminal that the first ones are chosen from.
const FIRST: usize = 16;

/// Distance of the first receiver from the first transmitter, as near as there is one \[m\].
const FIRST_M: f64 = 60.0;

/// Lines of a survey that may wait for their reader.
const LINES_AHEAD: usize = 4;

/// Time for a reader to take a line \[s\].
const STALL_S: u64 = 30;

/// Questions that are answered with JSON.
const QUESTIONS: [&str; 4] = ["map", "link", "compare", "coverage"];

/// Number of a page, drawn by itself; its requests overtake each other.
const PAGE: &str = "x-page";

/// The server's state.
#[derive(Debug)]
pub struct App {
    latest: LatestRequests,
    /// Workers for links, which are not to wait for the others.
    quick: Workers,
    /// Workers for comparisons, coverage and files.
    slow: Workers,
}

impl App {
    /// The state at the start.
    ///
    /// # Errors
    /// Threads that cannot be started.
    pub fn new(cache: Cache) -> Result<Arc<Self>, ThreadPoolBuildError> {
        Ok(Arc::new(Self {
            latest: LatestRequests::default(),
            slow: Workers::new(cache.with_own_threads()?),
            quick: Workers::new(cache),
        }))
    }

    /// Answers a request that came to `port`.
    pub async fn answer(&self, request: Request<Incoming>, port: u16) -> Reply {
        let answered = self.try_answer(request, port).await;
        answered.unwrap_or_else(|fault| reply::fault(&fault))
    }

    async fn try_answer(&self, request: Request<Incoming>, port: u16) -> Result<Reply, Fault> {
        let (head, body) = request.into_parts();
        guard::check(&head.method, &head.uri, &head.headers, port)?;
        let path = head.uri.path();
        if let Some(file) = page::file(path) {
            return must_be(&head, Method::GET).map(|()| file);
        }
        if path == "/api/maps" {
            must_be(&head, Method::GET)?;
            let maps = self.quick.cache.maps();
            let told = json!({ "source": maps.source.to_string(), "ids": maps.ids });
            return Ok(reply::json(&told));
        }
        let name = path.strip_prefix("/api/").ok_or(Fault::NotFound)?;
        let mut kinds = QUESTIONS.into_iter().chain(files::NAMES);
        let kind = kinds.find(|&kind| kind == name).ok_or(Fault::NotFound)?;
        must_be(&head, Method::POST)?;
        let handle = self.latest.register(page_of(&head), kind);
        let held = handle.held();
        let body = body_of(&head, body).await?;
        let reply = match kind {
            "map" => work(&self.quick, &body, handle, map).await?,
            "link" => work(&self.quick, &body, handle, answer).await?,
            "compare" => work(&self.slow, &body, handle, compare).await?,
            "coverage" => {
                let question: CoverageQuestion = read(&body)?;
                return self.coverage(question, handle, held).await;
            }
            _ => {
                let question: LinkQuestion = read(&body)?;
                let make = move |cache: &Cache| files::make(kind, cache, &question, &handle);
                self.slow.run(make).await?
            }
        };
        drop(held);
        Ok(reply)
    }

    async fn coverage(
        &self,
        question: CoverageQuestion,
        handle: RequestHandle,
        held: Held,
    ) -> Result<Reply, Fault> {
        let make = move |cache: &Cache| Survey::new(cache, &question, handle);
        let survey = self.slow.run(make).await?;
        let (sender, receiver) = mpsc::channel(LINES_AHEAD);
        tokio::spawn(deliver(self.slow.clone(), survey, sender));
        Ok(reply::parts(Parts::new(receiver, held)))
    }
}

/// Computes an answer.
async fn work<Q, A>(
    workers: &Workers,
    body: &[u8],
    handle: RequestHandle,
    compute: fn(&Cache, &Q, &RequestHandle) -> Result<A, Fault>,
) -> Result<Reply, Fault>
where
    Q: DeserializeOwned + Send + 'static,
    A: Serialize + 'static,
{
    let question: Q = read(body)?;
    let answer = move |cache: &Cache| Ok(reply::json(&compute(cache, &question, &handle)?));
    workers.run(answer).await
}

/// Computes the lines of a survey as their reader takes them, and no further: one that stalls keeps no worker from others.
async fn deliver(workers: Workers, mut survey: Survey, sender: mpsc::Sender<Bytes>) {
    let patience = Duration::from_secs(STALL_S);
    while let Ok(Ok(place)) = tokio::time::timeout(patience, sender.reserve()).await {
        let next = workers.run(move |_| Ok((survey.next(), survey))).await;
        let Ok((Some(line), rest)) = next else {
            return;
        };
        survey = rest;
        place.send(line.into());
    }
}

fn must_be(head: &request::Parts, method: Method) -> Result<(), Fault> {
    match head.method == method {
        true => Ok(()),
        false => Err(Fault::Method(method)),
    }
}

/// The number of the page that asks; programs that give none are one page.
fn page_of(head: &request::Parts) -> u64 {
    let value = head.headers.get(PAGE).and_then(|value| value.to_str().ok());
    value.and_then(|text| text.parse().ok()).unwrap_or(0)
}

/// Reads a body of a bounded size in a bounded time.
async fn body_of(head: &request::Parts, body: Incoming) -> Result<Bytes, Fault> {
    let media_type = head.headers.get(CONTENT_TYPE);
    if media_type.is_none_or(|media_type| media_type != reply::JSON) {
        return Err(Fault::MediaType);
    }
    // As long as its head announces.
    if body.size_hint().lower() > MAX_BODY as u64 {
        return Err(Fault::TooLarge(MAX_BODY));
    }
    let whole = Limited::new(body, MAX_BODY).collect();
    let read = tokio::time::timeout(Duration::from_secs(BODY_S), whole).await;
    let read = read.map_err(|_| Fault::Slow(BODY_S))?;
    let bytes = read.map_err(|error| match error.is::<LengthLimitError>() {
        true => Fault::TooLarge(MAX_BODY),
        false => Fault::Cut,
    })?;
    Ok(bytes.to_bytes())
}

/// A map for the page.
#[derive(Debug, Serialize)]
struct MapAnswer {
    area: [[f64; 2]; 2],
    /// Outlines of the united buildings \[m\].
    rings: Vec<Vec<[f64; 2]>>,
    houses: Vec<HouseAnswer>,
    /// Number of houses of the map as it was read: drawn ones are numbered from there.
    as_read: usize,
    walls: usize,
    /// Findings in all houses, and in those of the map as it was read.
    repairs: String,
    repairs_as_read: String,
    /// Places of the terminals at first.
    tx: Option<[f64; 2]>,
    rx: Option<[f64; 2]>,
}

#[derive(Debug, Serialize)]
struct HouseAnswer {
    id: usize,
    rings: Vec<Vec<[f64; 2]>>,
    /// Findings in this house, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    repairs: Option<String>,
}

fn map(cache: &Cache, question: &CityQuestion, handle: &RequestHandle) -> Result<MapAnswer, Fault> {
    handle.check()?;
    let city = cache.city(question)?;
    let report = city.scene.report();
    let repairs_as_read = match question.houses.is_empty() {
        true => report.to_string(),
        false => {
            let as_read = CityQuestion {
                map: question.map,
                ..CityQuestion::default()
            };
            cache.city(&as_read)?.scene.report().to_string()
        }
    };
    let numbers = |ring: &Vec<DVec2>| ring.iter().map(|p| p.to_array()).collect::<Vec<_>>();
    let houses = city.houses.iter().enumerate().map(|(i, house)| {
        let repairs = report.repairs.iter().filter(|repair| repair.building == i);
        let own = RepairReport {
            repairs: repairs.copied().collect(),
        };
        let footprint = &house.footprint;
        let rings = std::iter::once(&footprint.outer).chain(&footprint.holes);
        HouseAnswer {
            id: house.id,
            rings: rings.map(numbers).collect(),
            repairs: (!own.is_clean()).then(|| own.to_string()),
        }
    });
    let seed = cache.maps().seed;
    let drawn = sampling::draw(&city.scene, seed, question.map, FIRST, 1..=FIRST).ok();
    // In the streets, if there is a choice: between two courtyards there is no path.
    let in_street = |&p: &DVec2| city.scene.courtyard_of(p).is_none();
    let tx = drawn.as_ref().and_then(|drawn| {
        let street = drawn.tx.iter().copied().find(in_street);
        street.or(drawn.tx.first().copied())
    });
    // Far from the transmitter there is often no path within the limits.
    let rx = drawn.as_ref().zip(tx).and_then(|(drawn, tx)| {
        let off = |p: &DVec2| (p.distance(tx) - FIRST_M).abs();
        let streets = drawn.rx.iter().copied().filter(in_street);
        let nearest = streets.min_by(|p, q| off(p).total_cmp(&off(q)));
        nearest.or(drawn.rx.first().copied())
    });
    Ok(MapAnswer {
        area: [city.area.min, city.area.max].map(|p| p.to_array()),
        rings: city.outlines.rings.iter().map(numbers).collect(),
        houses: houses.collect(),
        as_read: city.as_read,
        walls: city.scene.walls().len(),
        repairs: report.to_string(),
        repairs_as_read,
        tx: tx.map(|p| p.to_array()),
        rx: rx.map(|p| p.to_array()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::tests::cache;
    use crate::coverage::tests::survey;

    /// Runs an answer until no task can proceed, and then the clock of the timeouts.
    fn run<T>(future: impl Future<Output = T>) -> T {
        let mut runtime = tokio::runtime::Builder::new_current_thread();
        let runtime = runtime.enable_time().start_paused(true).build().unwrap();
        runtime.block_on(future)
    }

    #[test]
    fn readers_that_stall_leave_the_workers_to_others_and_are_given_up() {
        let workers = Workers::new(cache());
        run(async {
            let mut stalled = Vec::new();
            for page in 0..4 * Workers::most() as u64 {
                let handle = LatestRequests::default().register(page, "coverage");
                let (sender, receiver) = mpsc::channel(LINES_AHEAD);
                let lines = survey(&workers.cache, handle);
                let delivery = tokio::spawn(deliver(workers.clone(), lines, sender));
                stalled.push((delivery, receiver));
            }
            for (delivery, mut receiver) in stalled {
                // Ends only because it is given up: nothing is taken before.
                delivery.await.unwrap();
                for _ in 0..LINES_AHEAD {
                    assert!(receiver.recv().await.is_some());
                }
                assert!(receiver.recv().await.is_none());
            }
        });
    }

    #[test]
    fn survey_ends_with_its_reader() {
        let workers = Workers::new(cache());
        run(async {
            let handle = LatestRequests::default().register(1, "coverage");
            let lines = survey(&workers.cache, handle);
            let (sender, mut receiver) = mpsc::channel(LINES_AHEAD);
            let delivery = tokio::spawn(deliver(workers, lines, sender));
            for _ in 0..3 {
                assert!(receiver.recv().await.is_some());
            }
            drop(receiver);
            delivery.await.unwrap();
        });
    }
}
