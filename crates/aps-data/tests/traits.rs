//! What every type of the face can do: checked by the compiler. Writers are not copied: each holds a lock or a file. Errors are
//! not copied either: they carry what the system said.

use std::fmt::Debug;

use aps_data::*;

fn is_shared<T: Debug + Clone + Send + Sync + 'static>() {}
fn is_sent<T: Debug + Send + 'static>() {}
fn is_error<T: std::error::Error + Send + Sync + 'static>() {}

#[test]
fn types_can_be_shown_copied_and_shared() {
    is_shared::<Dataset>();
    is_shared::<Manifest>();
    is_shared::<MapEntry>();
    is_shared::<MapData>();
    is_shared::<Profile>();
    is_shared::<PathTable>();
    is_shared::<Survey>();
    is_shared::<Plan>();
    is_shared::<Split>();
    is_shared::<DatasetConfig>();
    is_shared::<Layout>();
    is_shared::<Raster>();
    is_shared::<ConditionConfig>();
    is_shared::<ConditionImages>();
    is_shared::<LinkStatus>();
    is_shared::<LinkRows<'static>>();
    is_shared::<MapInput<'static>>();
    is_sent::<DatasetWriter>();
    is_sent::<MapWriter<'static>>();
    is_error::<Error>();
    is_error::<RasterError>();
}
