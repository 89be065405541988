/// Pipelines: a config's stages over mesh values, and the report of what they did.
export module camber.run;
export import :fields;
export import :histogram;
export import :memory;
export import :report;
export import :order;
export import :pipeline;
export import :plan;
export import :plot;
export import :check;
import :check_parts;
import :measures;
import :mend;
import :parts;
import :rows;
import :state;
import :stages;
