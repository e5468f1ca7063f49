"""kneeviz: the knee in the browser, a thin view of kneecore."""
