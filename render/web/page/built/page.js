"use strict";(()=>{function Re(o){let e=atob(o),t=new Uint8Array(e.length);for(let r=0;r<e.length;++r)t[r]=e.charCodeAt(r);return t}var C=class{constructor(e,t){this.places=e;this.bytes=t}has(e){return e in this.places}place(e){let t=this.places[e];if(!t)throw new Error(`the data have no ${e}`);return t}f32(e){let[,t,r]=this.place(e);return new Float32Array(this.bytes.buffer,t,r)}integers(e){let[t,r,s]=this.place(e);return t==="u16"?new Uint16Array(this.bytes.buffer,r,s):new Uint32Array(this.bytes.buffer,r,s)}};function ie(o){window.ulfData=(e,t)=>o(e,Re(t))}async function se(o){for(let t=1;;++t)try{await new Promise((r,s)=>{let i=document.createElement("script");i.src=o,i.onload=()=>{i.remove(),r()},i.onerror=()=>{i.remove(),s(new Error(`${o} could not be loaded`))},document.head.append(i)});return}catch(r){if(t===4)throw r;await new Promise(s=>setTimeout(s,500*2**t))}}var y=(o,e)=>o[0]*e[0]+o[1]*e[1]+o[2]*e[2],x=(o,e)=>[o[1]*e[2]-o[2]*e[1],o[2]*e[0]-o[0]*e[2],o[0]*e[1]-o[1]*e[0]],p=(o,e)=>[o[0]*e,o[1]*e,o[2]*e],E=(o,e)=>[o[0]+e[0],o[1]+e[1],o[2]+e[2]],w=(o,e)=>[o[0]-e[0],o[1]-e[1],o[2]-e[2]],f=o=>Math.hypot(o[0],o[1],o[2]),V=o=>p(o,1/f(o)),L=(o,e,t)=>Math.min(Math.max(o,e),t),D=(o,e)=>Math.atan2(f(x(o,e)),y(o,e)),R=(o,e)=>[o[0]*e[0]+o[1]*e[1]+o[2]*e[2],o[3]*e[0]+o[4]*e[1]+o[5]*e[2],o[6]*e[0]+o[7]*e[1]+o[8]*e[2]],B=(o,e)=>[o[0]*e[0]+o[3]*e[1]+o[6]*e[2],o[1]*e[0]+o[4]*e[1]+o[7]*e[2],o[2]*e[0]+o[5]*e[1]+o[8]*e[2]];function q(o,e,t){let r=Math.cos(t);return E(E(p(o,r),p(x(e,o),Math.sin(t))),p(e,y(e,o)*(1-r)))}function ne(o,e){let t=V(p(o,-1)),r=V(x(t,e)),s=x(t,r);return[...r,...s,...t]}var K=2.5,Ve=1.1,oe=.035,N=class{constructor(e,t){this.header=e;this.field=t;this.zoom=1;this.eye=e.eye,this.up=V(e.up)}filling(e,t){let[r,s,i]=this.header.lens;return i*Math.max(e/r,t/s)}leastZoom(e,t){let[r,s]=this.header.lens;return Math.min(e/r,t/s)/Math.max(e/r,t/s)}startingZoom(e,t){let r=f(this.eye),s=this.header.radius/Math.sqrt(Math.max(r**2-this.header.radius**2,1e-12)),n=Math.min(e,t)/(2*1.25*s*this.filling(e,t));return L(n,this.leastZoom(e,t),Ve)}setZoom(e,t,r){this.zoom=L(e,this.leastZoom(t,r),K)}reset(e,t){this.eye=this.header.eye,this.zoom=this.startingZoom(e,t)}camera(e,t){return{eye:this.eye,camFromWorld:ne(this.eye,this.up),focalPx:this.zoom*this.filling(e,t),width:e,height:t}}turn(e,t){let r=Math.max(1,Math.ceil(Math.hypot(e,t)/.02)),s=!1;for(let i=0;i<r;++i){let n=[e/r,t/r];s=this.step(...n)||this.step(n[0],0)||this.step(0,n[1])||s}return s}step(e,t){if(e===0&&t===0)return!1;let r=D(this.eye,this.up),s=L(r-t,Math.min(oe,r),Math.max(Math.PI-oe,r)),i=V(x(this.up,this.eye)),n=q(this.eye,i,s-r);return n=q(n,this.up,e),!this.field.inside(n)&&this.field.inside(this.eye)?!1:(this.eye=p(V(n),f(this.header.eye)),!0)}};var O=[1,.84,.71,.59,.5,.42,.35],ae=34.5,Me=17.5,H=class{constructor(){this.index=0;this.smoothedMs=0;this.frames=0}get size(){return O[this.index]}note(e){this.smoothedMs=this.frames===0?e:.6*this.smoothedMs+.4*e,++this.frames;let t=3,r=30;if(this.frames>=t&&this.smoothedMs>ae&&this.index+1<O.length){let s=this.size*Math.sqrt(ae/this.smoothedMs),i=O.findIndex(n=>n<=s);this.change(i<0?O.length-1:Math.max(i,this.index+1))}else this.frames>=r&&this.smoothedMs<Me&&this.index>0&&this.change(this.index-1)}change(e){this.index=e,this.frames=0}};function he(o,e){let t=new Map,r={x:0,y:0,time:0,travelled:0},s=0,i=()=>{let[h,a]=[...t.values()];return h&&a?Math.hypot(h.x-a.x,h.y-a.y):0};o.addEventListener("pointerdown",h=>{h.button===0&&(o.setPointerCapture(h.pointerId),t.set(h.pointerId,{x:h.clientX,y:h.clientY}),r={x:h.clientX,y:h.clientY,time:h.timeStamp,travelled:t.size>1?6:0},s=i(),o.classList.add("held"))}),o.addEventListener("pointermove",h=>{let a=t.get(h.pointerId);if(!a)return;let d=h.clientX-a.x,u=h.clientY-a.y;if(a.x=h.clientX,a.y=h.clientY,r.travelled=Math.max(r.travelled,Math.hypot(h.clientX-r.x,h.clientY-r.y)),t.size===1)r.travelled>=6&&e.turn(-d*.005,u*.005);else{let l=i();s>0&&l>0&&e.zoomBy(l/s),s=l}});let n=h=>{t.delete(h.pointerId)&&(s=i(),!(t.size>0)&&(o.classList.remove("held"),e.rest(),h.type==="pointerup"&&r.travelled<6&&h.timeStamp-r.time<350&&e.focusAt(h.clientX,h.clientY)))};o.addEventListener("pointerup",n),o.addEventListener("pointercancel",n),o.addEventListener("wheel",h=>{h.preventDefault();let a=h.deltaMode===1?16:h.deltaMode===2?400:1;e.zoomBy(Math.exp(-h.deltaY*a*.0015))},{passive:!1}),window.addEventListener("keydown",h=>{h.ctrlKey||h.metaKey||h.altKey||h.target instanceof HTMLInputElement&&h.key.startsWith("Arrow")||e.key(h)&&h.preventDefault()})}var k=12;function le(o,e){let t=o.f32("cameras"),r=[];for(let s=0;s<e;++s){let i=a=>t[18*s+a],n=[i(6),i(7),i(8),i(10),i(11),i(12),i(14),i(15),i(16)],h=[i(9),i(13),i(17)];r.push({fx:i(0),fy:i(1),cx:i(2),cy:i(3),width:i(4),height:i(5),camFromWorld:n,translation:h,center:p(B(n,h),-1)})}return r}var Pe=.001;function j(o,e,t){let r=x(e,t),s=y(o,r);return Math.abs(s)>1e-15*f(o)*f(e)*f(t)?[p(r,1/s),p(x(t,o),1/s),p(x(o,e),1/s)]:null}function _e(o,e){let t=[0,0,0,0,0],r=o.map(s=>{let i=2*e.focalPx*s[0]/e.width,n=-2*e.focalPx*s[1]/e.height;return s[2]<=0&&++t[0],i>s[2]&&++t[1],-i>s[2]&&++t[2],n>s[2]&&++t[3],-n>s[2]&&++t[4],[i,n,s[2]]});return t.includes(3)?null:r}function ce(o,e,t){let r=Math.max(...e.map(f)),s=e.map(n=>p(n,1/r)),i=t;return i.length>k&&(i=[...i].sort((n,h)=>h.weights[0]+h.weights[1]+h.weights[2]-n.weights[0]-n.weights[1]-n.weights[2]).slice(0,k)),{corners:o,denominator:E(E(s[0],s[1]),s[2]),fans:i.map(({view:n,weights:h})=>({view:n,numerator:E(E(p(s[0],h[0]),p(s[1],h[1])),p(s[2],h[2]))}))}}var G=class{constructor(e,t){this.cameras=t;this.positions=[];this.triangles=[];this.entries=[];this.viewsOfVertex=[];this.hull=[];let r=e.f32("positions");for(let u=0;u<r.length;u+=3)this.positions.push([r[u],r[u+1],r[u+2]]);let s=(u,l)=>{let c=e.integers(u);for(let m=0;m<c.length;m+=3)l.push([c[m],c[m+1],c[m+2]])};s("triangles",this.triangles),s("hull",this.hull);let i=e.integers("firstWeight"),n=e.integers("weightVertex"),h=e.f32("weight");for(let u of this.triangles){let l=new Map;u.forEach((c,m)=>{for(let v=i[c];v<i[c+1];++v){let g=l.get(n[v])??[0,0,0];g[m]+=h[v],l.set(n[v],g)}}),this.entries.push([...l].map(([c,m])=>({vertex:c,weights:m})))}let a=e.integers("firstViewOfVertex"),d=e.integers("viewOfVertex");for(let u=0;u+1<a.length;++u)this.viewsOfVertex.push(Array.from(d.subarray(a[u],a[u+1])))}inside(e){return this.hull.some(t=>{let r=t.map(s=>this.positions[s]);return[0,1,2].every(s=>y(e,x(r[s],r[(s+1)%3]))>=0)})}offTheMesh(e){let t=V(e);for(let r=this.triangles.length-1;r>=0;--r){let[s,i,n]=this.triangles[r].map(g=>this.positions[g]),h=j(s,i,n);if(!h||h.some(g=>y(g,t)<0))continue;let a=w(i,s),d=w(n,i),u=w(s,n),l=V(x(a,p(u,-1))),c=Pe*Math.min(f(a),f(d),f(u)),m=-y(l,w(s,e)),v=y(l,t);return Math.abs(m)>=c||v<=0?e:E(e,p(t,((m<0?-c:c)-m)/v))}return e}viewAt(e,t){let r=this.viewsOfVertex[e],s=r[0];for(let i of r)Math.abs(f(this.cameras[i].center)-t)<Math.abs(f(this.cameras[s].center)-t)&&(s=i);return s}place(e){let t=this.offTheMesh(e.eye),r=f(e.eye),s=this.positions.map(n=>R(e.camFromWorld,w(n,t))),i=[];return this.triangles.forEach((n,h)=>{let a=n.map(l=>s[l]);y(a[0],x(a[1],a[2]))>0&&(a=a.map(l=>p(l,-1)));let d=_e(a,e);if(!d)return;let u=j(...a);u&&i.push(ce(d,u,this.entries[h].map(({vertex:l,weights:c})=>({view:this.viewAt(l,r),weights:c}))))}),i}},W=class{constructor(e,t){this.header=e;this.cameras=t}weightsAt(e,t){let r=w(t,e),s=[];this.cameras.forEach((l,c)=>{let m=E(R(l.camFromWorld,e),l.translation),v=l.fx*m[0]/m[2]+l.cx,g=l.fy*m[1]/m[2]+l.cy;if(m[2]<=0||v<0||g<0||v>1||g>1)return;let P=w(l.center,e);s.push([D(r,P)+this.header.lumigraphResolution*Math.max(0,f(P)/f(r)-1),c])}),s.sort((l,c)=>l[0]-c[0]);let i=Math.max(1,this.header.lumigraphViews),n=s.slice(0,i),h=new Map;if(n.length===0)return h;let a=n[n.length-1][0],d=s.length>i?Math.max(s[i][0],1.001*a):1.1*a;if(n[0][0]<=1e-6)return h.set(n[0][1],1);let u=0;for(let[l]of n)u+=Math.max(0,1-l/d)/l;for(let[l,c]of n)h.set(c,Math.max(0,1-l/d)/l/u);return h}place(e){let s=f(e.eye),i=p(e.eye,-1/s),n=[];for(let d=0;d<=6;++d)for(let u=0;u<=8;++u){let l=[2*u/8-1,2*d/6-1,1],c=[l[0]*e.width/(2*e.focalPx),-l[1]*e.height/(2*e.focalPx),1],m=B(e.camFromWorld,c),v=Math.max(y(m,i),.001);n.push({ray:c,clip:l,weights:this.weightsAt(E(e.eye,p(m,s/v)),e.eye)})}let h=[],a=(d,u,l)=>{let c=[n[d],n[u],n[l]],m=j(c[0].ray,c[1].ray,c[2].ray);if(!m)return;let v=new Map;c.forEach((g,P)=>{for(let[b,z]of g.weights){let re=v.get(b)??[0,0,0];re[P]=z,v.set(b,re)}}),h.push(ce(c.map(g=>g.clip),m,[...v].map(([g,P])=>({view:g,weights:P}))))};for(let d=0;d<6;++d)for(let u=0;u<8;++u){let l=d*9+u;a(l,l+1,l+8+1),a(l+1,l+8+2,l+8+1)}return h}inside(e){let t=L(this.header.spacing||.15,.02,.3);return this.cameras.some(r=>D(r.center,e)<=t)}};var T=class{constructor(e,t,r){this.gl=e;this.places=new Map;let s=e.createProgram();for(let[n,h]of[[e.VERTEX_SHADER,t],[e.FRAGMENT_SHADER,r]]){let a=e.createShader(n);if(!a)throw new Error("the graphics were lost");if(e.shaderSource(a,h),e.compileShader(a),e.attachShader(s,a),!e.getShaderParameter(a,e.COMPILE_STATUS)&&!e.isContextLost())throw new Error(`shader: ${e.getShaderInfoLog(a)}`);e.deleteShader(a)}if(e.linkProgram(s),!e.getProgramParameter(s,e.LINK_STATUS)&&!e.isContextLost())throw new Error(`shaders: ${e.getProgramInfoLog(s)}`);this.program=s;let i=e.getUniformBlockIndex(s,"Views");i!==e.INVALID_INDEX&&e.uniformBlockBinding(s,i,0)}use(){return this.gl.useProgram(this.program),this}at(e){return this.places.has(e)||this.places.set(e,this.gl.getUniformLocation(this.program,e)),this.places.get(e)??null}integer(e,t){return this.gl.uniform1i(this.at(e),t),this}vectors(e,t){return this.gl.uniform4fv(this.at(e),t),this}numbers(e,...t){let r=this.at(e);return t.length===1?this.gl.uniform1f(r,t[0]):t.length===3?this.gl.uniform3fv(r,t):this.gl.uniform4fv(r,t),this}};function X(o,e,t){let r=o.createTexture();return o.bindTexture(e,r),o.texParameteri(e,o.TEXTURE_MIN_FILTER,t),o.texParameteri(e,o.TEXTURE_MAG_FILTER,t),o.texParameteri(e,o.TEXTURE_WRAP_S,o.CLAMP_TO_EDGE),o.texParameteri(e,o.TEXTURE_WRAP_T,o.CLAMP_TO_EDGE),r}var M=class{constructor(e,t,r){this.gl=e;this.format=t;this.width=0;this.height=0;this.texture=X(e,e.TEXTURE_2D,r),this.frame=e.createFramebuffer()}get isDepth(){return this.format===this.gl.DEPTH_COMPONENT24}resize(e,t){if(e===this.width&&t===this.height)return;let r=this.gl;this.width=e,this.height=t,r.bindTexture(r.TEXTURE_2D,this.texture);let[s,i]=this.isDepth?[r.DEPTH_COMPONENT,r.UNSIGNED_INT]:this.format===r.R16F?[r.RED,r.HALF_FLOAT]:this.format===r.RGBA8?[r.RGBA,r.UNSIGNED_BYTE]:[r.RED,r.UNSIGNED_BYTE];r.texImage2D(r.TEXTURE_2D,0,this.format,e,t,0,s,i,null),r.bindFramebuffer(r.FRAMEBUFFER,this.frame),r.framebufferTexture2D(r.FRAMEBUFFER,this.isDepth?r.DEPTH_ATTACHMENT:r.COLOR_ATTACHMENT0,r.TEXTURE_2D,this.texture,0),this.isDepth&&(r.drawBuffers([r.NONE]),r.readBuffer(r.NONE))}bind(){this.gl.bindFramebuffer(this.gl.FRAMEBUFFER,this.frame),this.gl.viewport(0,0,this.width,this.height)}copyToScreen(){let e=this.gl,{width:t,height:r}=this;e.bindFramebuffer(e.READ_FRAMEBUFFER,this.frame),e.bindFramebuffer(e.DRAW_FRAMEBUFFER,null),e.blitFramebuffer(0,0,t,r,0,0,t,r,e.COLOR_BUFFER_BIT,e.NEAREST),e.bindFramebuffer(e.FRAMEBUFFER,null),e.viewport(0,0,t,r)}};var A=`#version 300 es
precision highp float;
precision highp int;
precision highp sampler2DArray;
`,Q=`
uniform sampler2DArray pictures;
uniform float masks;  // 1 where views' alpha hides something

// The light of a view for the point at \`inverse\` depth along the ray; alpha: how much it sees of it. Of the view: rows of
// its picture (of size 1) from this camera, with the translation; feathers' inverse widths, layer, the factor of inverse
// depths; scale and offset in the layer.
vec4 see(vec4 row0, vec4 row1, vec4 row2, vec4 more, vec4 place, vec3 ray, float inverse, out float feather) {
  vec3 p = vec3(dot(row0.xyz, ray), dot(row1.xyz, ray), dot(row2.xyz, ray)) + inverse * vec3(row0.w, row1.w, row2.w);
  float far = 1.0 / p.z;
  vec2 uv = p.xy * far;
  vec2 edge = min(uv, 1.0 - uv) * more.xy;
  feather = p.z > 0.0 ? clamp(min(edge.x, edge.y), 0.0, 1.0) : 0.0;
  vec4 light = textureLod(pictures, vec3(place.xy * uv + place.zw, more.z), 0.0);
  float nearness = min(inverse * far * more.w, 0.985);
  float seen = clamp((nearness - 1.0 + light.a) * 255.0 + 1.0, 0.0, 1.0);
  return vec4(light.rgb, feather * mix(1.0, seen, masks));
}

vec3 srgb(vec3 light) {
  // Within 0.2 levels of 255 of the exact curve.
  vec3 a = sqrt(clamp(light, 0.0, 1.0)), b = sqrt(a), c = sqrt(b);
  return 0.662002687 * a + 0.684122060 * b - 0.323583601 * c - 0.0225411470 * a * a;
}
`,ue=`
// Of each view what see() wants, and its centre in this camera.
layout(std140) uniform Views { vec4 views[1020]; };
vec4 seeView(int v, vec3 ray, float inverse, out float feather) {
  int at = 6 * v;
  return see(views[at], views[at + 1], views[at + 2], views[at + 3], views[at + 4], ray, inverse, feather);
}
`,J=`
uniform vec4 camera;         // half of the width and height, 1 / focal length, 1 / near
uniform vec4 plane;          // normal . ray = offset / depth: normal / offset, and the least inverse depth
uniform float focusInverse;  // above 0: of the focal plane, in place of everything
uniform float holesScale;    // above 0: inverse depths in \`holes\`
uniform highp sampler2D nearness;  // 1 - near / depth; 1 without a triangle
uniform highp sampler2D holes;

vec3 rayOfPixel() { return vec3((gl_FragCoord.xy - camera.xy) * vec2(camera.z, -camera.z), 1.0); }

float inverseDepth(vec3 ray) {
  if (focusInverse > 0.0) return focusInverse;
  float far = texelFetch(nearness, ivec2(gl_FragCoord.xy), 0).r;
  float inverse = (1.0 - far) * camera.w;
  if (far >= 1.0) {
    inverse = holesScale > 0.0 ? texture(holes, 0.5 * gl_FragCoord.xy / camera.xy).r * holesScale : 0.0;
    if (inverse <= 0.0) inverse = max(dot(plane.xyz, ray), plane.w);
  }
  return inverse;
}
`,de=`${A}
uniform vec4 corners[3];  // of clip space
void main() { gl_Position = corners[gl_VertexID]; }`,me=o=>`${A}${Q}${J}
uniform vec4 own[${6*o}];  // of each view what see() wants, and the numerator of its weight
uniform vec3 denominator;
out vec4 color;

void main() {
  vec3 ray = rayOfPixel();
  float inverse = inverseDepth(ray);
  vec4 all = vec4(0.0);
  float feather;
${Array.from({length:o},(e,t)=>{let r=s=>`own[${6*t+s}]`;return`  {
    vec4 light = see(${[0,1,2,3,4].map(r).join(", ")}, ray, inverse, feather);
    float weight = max(dot(${r(5)}.xyz, ray), 0.0) * light.a;
    all += vec4(light.rgb * weight, weight);
  }`}).join(`
`)}
  float share = clamp(2.0 * all.a / max(dot(denominator, ray), 1e-30), 0.0, 1.0);
  color = vec4(srgb(all.rgb / max(all.a, 1e-30)), share);
}`,U=16,fe=`${A}
uniform sampler2D drawn;
out vec4 color;
void main() {
  ivec2 first = ${U} * ivec2(gl_FragCoord.xy), last = textureSize(drawn, 0) - 1;
  float least = 1.0;
  for (int y = 0; y < ${U}; ++y)
    for (int x = 0; x < ${U}; ++x) least = min(least, texelFetch(drawn, min(first + ivec2(x, y), last), 0).a);
  color = vec4(least < 0.996 ? 1.0 : 0.0);
}`,pe=`${A}
uniform sampler2D openTiles;
uniform vec4 camera;  // half of the width and height
void main() {
  const ivec2 corners[6] = ivec2[6](ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(0, 1), ivec2(1, 0), ivec2(1, 1));
  int columns = textureSize(openTiles, 0).x;
  ivec2 tile = ivec2(gl_InstanceID % columns, gl_InstanceID / columns);
  vec2 corner = vec2(${U} * (tile + corners[gl_VertexID])) / camera.xy - 1.0;
  gl_Position = texelFetch(openTiles, tile, 0).r > 0.5 ? vec4(corner, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
}`,ve=`${A}${Q}${ue}${J}
uniform sampler2D drawn;
uniform int filling;
out vec4 color;

void main() {
  color = texelFetch(drawn, ivec2(gl_FragCoord.xy), 0);
  bool finished = color.a >= 0.996;
  float most = finished ? 1.0 : 0.5 * color.a;  // the clearest view of the point
  vec4 others = vec4(0.0), hidden = vec4(0.0);
  vec3 ray = rayOfPixel();
  float inverse = inverseDepth(ray);
  vec3 point = ray / inverse;
  int count = 0;
  for (int n = 0; n < filling && count < 4 && !finished; ++n) {
    float feather;
    vec4 light = seeView(n, ray, inverse, feather);
    if (feather <= 0.0) continue;
    most = max(most, feather);
    if (hidden.a == 0.0) hidden = vec4(light.rgb * feather, feather);
    if (light.a <= 0.0) continue;
    vec3 toView = views[6 * n + 5].xyz - point;
    float penalty = acos(clamp(dot(-point, toView) * inversesqrt(dot(point, point) * dot(toView, toView)), -1.0, 1.0));
    float weight = light.a / max(penalty, 1e-3);
    others += vec4(light.rgb * weight, weight);
    ++count;
  }
  if (others.a <= 0.0) others = hidden;
  if (others.a > 0.0) color.rgb = mix(srgb(others.rgb / others.a), color.rgb, color.a);
  float there = color.a + others.a > 0.0 ? clamp(most, 0.0, 1.0) : 0.0;
  color = vec4(color.rgb * there, there);
}`,_=`${A}
uniform float depth;
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, depth, 1.0); }`,be=`${A}${Q}${ue}${J}
uniform int count;
uniform float inverseRadius;
out vec4 color;

void main() {
  vec3 ray = rayOfPixel();
  float feather;
  vec4 all = vec4(0.0);
  vec3 point = ray / focusInverse;
  for (int n = 0; n < count; ++n) {
    vec3 center = views[6 * n + 5].xyz;
    vec2 through = mix(point.xy, center.xy, point.z / (point.z - center.z)) * inverseRadius;
    float from_middle = dot(through, through);
    if (from_middle >= 1.0 || center.z >= point.z) continue;
    vec4 light = seeView(n, ray, focusInverse, feather);
    float weight = (1.0 - from_middle) * (1.0 - from_middle) * feather;
    all += vec4(light.rgb * weight, weight);
  }
  color = all.a > 0.0 ? vec4(srgb(all.rgb / all.a), 1.0) : vec4(0.0);
}`,ge=`${A}
layout(location = 0) in vec3 place;
uniform vec3 low, step;
uniform vec4 row0, row1, row2;  // of the camera
uniform vec4 lens;              // to clip space: x scale, y scale, x offset, y offset
uniform float near;
void main() {
  vec4 h = vec4(low + step * place, 1.0);
  vec3 p = vec3(dot(row0, h), dot(row1, h), dot(row2, h));
  gl_Position = vec4(p.xy * lens.xy + p.z * lens.zw, p.z - 2.0 * near, p.z);
}`,we=`${A}
void main() {}`,ye=`${A}
uniform highp sampler2D finer;
uniform bool ofNearness;
out vec4 color;
void main() {
  // The first level is a quarter of the picture, of one in four pixels: depths of holes are smooth.
  int apart = ofNearness ? 2 : 1;
  ivec2 size = textureSize(finer, 0), first = 2 * apart * ivec2(gl_FragCoord.xy);
  float total = 0.0, known = 0.0;
  for (int n = 0; n < 4; ++n) {
    ivec2 at = first + apart * ivec2(n & 1, n >> 1);
    if (any(greaterThanEqual(at, size))) continue;
    float value = texelFetch(finer, at, 0).r;
    if (ofNearness) value = 1.0 - value;
    if (value <= 0.0) continue;
    total += value;
    known += 1.0;
  }
  color = vec4(known > 0.0 ? total / known : 0.0);
}`,xe=`${A}
uniform highp sampler2D coarser, pulled;
out vec4 color;
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  float own = texelFetch(pulled, here, 0).r;
  ivec2 last = textureSize(coarser, 0) - 1, at = here / 2;
  ivec2 beside = clamp(at + 2 * (here & 1) - 1, ivec2(0), last);
  float around = (9.0 * texelFetch(coarser, at, 0).r + 3.0 * texelFetch(coarser, ivec2(beside.x, at.y), 0).r +
                  3.0 * texelFetch(coarser, ivec2(at.x, beside.y), 0).r + texelFetch(coarser, beside, 0).r) / 16.0;
  color = vec4(own > 0.0 ? own : around);
}`,Ee=`${A}
uniform highp sampler2D nearness;
uniform float scale;  // to the view's factor
out vec4 color;
float at(ivec2 place) {
  ivec2 size = textureSize(nearness, 0);
  if (any(lessThan(place, ivec2(0))) || any(greaterThanEqual(place, size))) return 0.0;
  return 1.0 - texelFetch(nearness, place, 0).r;
}
float slope(float before, float here, float behind) {
  float back = before > 0.0 ? abs(here - before) : -1.0, on = behind > 0.0 ? abs(behind - here) : -1.0;
  if (back < 0.0 || on < 0.0) return max(max(back, on), 0.0);
  return max(back, on) < 0.1 * here ? max(back, on) : min(back, on);
}
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  float value = at(here);
  float change = slope(at(here - ivec2(1, 0)), value, at(here + ivec2(1, 0))) +
                 slope(at(here - ivec2(0, 1)), value, at(here + ivec2(0, 1)));
  float least = value > 0.0 ? max(0.0, 0.99 * value - 2.0 * change) : 0.0;
  color = vec4(floor(min(least * scale, 0.98) * 255.0) / 255.0);
}`,Te=`${A}
uniform highp sampler2D narrow;
out vec4 color;
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(narrow, 0) - 1;
  float most = 0.0;
  for (int n = 0; n < 9; ++n)
    most = max(most, texelFetch(narrow, clamp(here + ivec2(n % 3, n / 3) - 1, ivec2(0), last), 0).r);
  color = vec4(most);
}`,Ae=`${A}
uniform highp sampler2DArray hides;
uniform vec4 area;  // of the picture in its layer: offset, 1 / size
uniform float layer;
out vec4 color;
void main() {
  color = vec4(0.0, 0.0, 0.0, 1.0 - texture(hides, vec3((gl_FragCoord.xy - area.xy) * area.zw, layer)).r);
}`;var $=class{constructor(e,t,r){this.gl=e;this.header=t;this.program=new T(e,ge,we),this.places=r.integers("places"),this.corners=r.integers("corners"),this.count=this.corners.length,this.cornerType=this.corners instanceof Uint16Array?e.UNSIGNED_SHORT:e.UNSIGNED_INT,this.vertices=e.createVertexArray(),e.bindVertexArray(this.vertices),e.bindBuffer(e.ARRAY_BUFFER,e.createBuffer());let s=new Uint16Array(this.places.length/3*4);for(let i=0;3*i<this.places.length;++i)s.set(this.places.subarray(3*i,3*i+3),4*i);e.bufferData(e.ARRAY_BUFFER,s,e.STATIC_DRAW),e.enableVertexAttribArray(0),e.vertexAttribPointer(0,3,e.UNSIGNED_SHORT,!1,8,0),e.bindBuffer(e.ELEMENT_ARRAY_BUFFER,e.createBuffer()),e.bufferData(e.ELEMENT_ARRAY_BUFFER,this.corners,e.STATIC_DRAW),e.bindVertexArray(null)}drawNearness(e,t,r,s){let i=this.gl,n=e,h=t;i.enable(i.DEPTH_TEST),i.depthFunc(i.LESS),i.clear(i.DEPTH_BUFFER_BIT),this.program.use().numbers("low",...this.header.low).numbers("step",...this.header.step).numbers("row0",n[0],n[1],n[2],h[0]).numbers("row1",n[3],n[4],n[5],h[1]).numbers("row2",n[6],n[7],n[8],h[2]).numbers("lens",...r).numbers("near",s),i.bindVertexArray(this.vertices),i.drawElements(i.TRIANGLES,this.count,this.cornerType,0),i.bindVertexArray(null),i.disable(i.DEPTH_TEST)}vertex(e){let{low:t,step:r}=this.header;return[0,1,2].map(s=>t[s]+r[s]*this.places[3*e+s])}hit(e,t){let r=null;for(let s=0;s<this.count;s+=3){let i=this.vertex(this.corners[s]),n=w(this.vertex(this.corners[s+1]),i),h=w(this.vertex(this.corners[s+2]),i),a=x(t,h),d=y(n,a);if(d===0)continue;let u=w(e,i),l=y(u,a)/d;if(l<0||l>1)continue;let c=x(u,n),m=y(t,c)/d;if(m<0||l+m>1)continue;let v=y(h,c)/d;v>0&&(r===null||v<r)&&(r=v)}return r}};var Le=125e6,S=256,Se=3,Y=class{constructor(e,t,r,s,i){this.gl=e;this.cameras=r;this.geometry=s;this.changed=i;this.slots=[];this.decoding=new Set;this.drawing=0;this.hasMasks=!1;this.shown=0;[this.width,this.height]=t.picture;let n=t.small;this.smallWidth=Math.max(1,Math.floor(this.width/n)),this.smallHeight=Math.max(1,Math.floor(this.height/n)),this.smallLayers=Math.ceil(t.views/n**2),this.places=new Array(t.views),this.smallIn=new Array(t.views).fill(!1),this.fine=new Array(t.views);let h=e.getParameter(e.MAX_ARRAY_TEXTURE_LAYERS),a=4*this.width*this.height,d=Math.min(t.views,h),u=Math.floor((Le-d*S**2)/a)-this.smallLayers,l=Math.max(1,Math.min(t.views,u,h-this.smallLayers));this.bytes=(this.smallLayers+l)*a+d*S**2,this.texture=X(e,e.TEXTURE_2D_ARRAY,e.LINEAR),e.texStorage3D(e.TEXTURE_2D_ARRAY,1,e.SRGB8_ALPHA8,this.width,this.height,this.smallLayers+l),this.frame=e.createFramebuffer();for(let c=0;c<l;++c)this.slots.push({view:-1,usedAt:-1});this.hides=X(e,e.TEXTURE_2D_ARRAY,e.LINEAR),e.texStorage3D(e.TEXTURE_2D_ARRAY,1,e.R8,S,S,d),this.hidesFrame=e.createFramebuffer(),this.hidesOf=new Array(d).fill(-1),this.nearness=new M(e,e.DEPTH_COMPONENT24,e.NEAREST),this.narrow=new M(e,e.R8,e.NEAREST),this.nearness.resize(S,S),this.narrow.resize(S,S),this.narrowProgram=new T(e,_,Ee),this.widenProgram=new T(e,_,Te),this.openProgram=new T(e,_,Ae),this.radius=t.radius}place(e){return this.places[e]}get masks(){return this.hasMasks||this.geometry()!==null}nearnessFactor(e){let t=f(this.cameras[e].center),r=this.radius<.5*t?(t-this.radius)/1.25:t/2.5;return Math.max(r,1e-9)}addSmall(e,t){return this.decode(e,new Blob([t],{type:"image/webp"}),this.smallWidth,this.smallHeight,r=>{let s=Math.round(this.width/this.smallWidth),i=e%s**2,n=i%s*this.smallWidth,h=Math.floor(i/s)*this.smallHeight;this.smallIn[e]=!0,++this.shown;let a=this.smallPlace(e);this.upload(e,r,a.layer,n,h,this.smallWidth,this.smallHeight),this.places[e]||(this.places[e]=a)})}smallPlace(e){let t=Math.round(this.width/this.smallWidth),r=e%t**2;return{layer:Math.floor(e/t**2),scaleX:this.smallWidth/this.width,scaleY:this.smallHeight/this.height,offsetX:r%t*this.smallWidth/this.width,offsetY:Math.floor(r/t)*this.smallHeight/this.height,fine:!1}}addFine(e,t){this.fine[e]=new Blob([t],{type:"image/webp"})}async decode(e,t,r,s,i){let n=this.cameras[e],h=r===this.width?[n.width,n.height]:[Math.floor(n.width/4),Math.floor(n.height/4)],a={premultiplyAlpha:"none",colorSpaceConversion:"none"};(h[0]!==r||h[1]!==s)&&Object.assign(a,{resizeWidth:r,resizeHeight:s,resizeQuality:"medium"});let d=await createImageBitmap(t,a).catch(()=>createImageBitmap(t));this.gl.isContextLost()||i(d),d.close(),this.decoding.delete(e),this.changed(e)}want(e){++this.drawing;for(let t of e){let r=this.slots.find(s=>s.view===t);r&&(r.usedAt=this.drawing)}for(let t of e){if(this.decoding.size>=Se)return;let r=this.fine[t];if(!r||this.decoding.has(t)||this.slots.some(i=>i.view===t))continue;let s=this.slots.reduce((i,n)=>n.usedAt<i.usedAt?n:i);if(s.usedAt===this.drawing)return;s.view>=0&&(this.places[s.view]=this.smallIn[s.view]?this.smallPlace(s.view):void 0),s.view=t,s.usedAt=this.drawing,this.decoding.add(t),this.decode(t,r,this.width,this.height,i=>{if(s.view!==t)return;let n=this.smallLayers+this.slots.indexOf(s);this.upload(t,i,n,0,0,this.width,this.height),this.places[t]={layer:n,scaleX:1,scaleY:1,offsetX:0,offsetY:0,fine:!0}}).catch(()=>{this.fine[t]=void 0,this.decoding.delete(t),s.view=-1})}}waits(e){return e.slice(0,this.slots.length).some(t=>this.fine[t]&&!this.places[t]?.fine)}get fineViews(){return this.slots.length}noteMasks(){this.hasMasks=!0}upload(e,t,r,s,i,n,h){let a=this.gl;a.pixelStorei(a.UNPACK_PREMULTIPLY_ALPHA_WEBGL,!1),a.pixelStorei(a.UNPACK_COLORSPACE_CONVERSION_WEBGL,a.NONE),a.bindTexture(a.TEXTURE_2D_ARRAY,this.texture),a.texSubImage3D(a.TEXTURE_2D_ARRAY,0,s,i,r,n,h,1,a.RGBA,a.UNSIGNED_BYTE,t);let d=this.geometry();d&&this.hide(e,d,r,s,i,n,h)}hide(e,t,r,s,i,n,h){let a=this.gl,d=e%this.hidesOf.length;if(this.hidesOf[d]!==e){this.hidesOf[d]=e;let u=this.cameras[e],l=.02*f(u.center);this.nearness.bind(),t.drawNearness(u.camFromWorld,u.translation,[2*u.fx,2*u.fy,2*u.cx-1,2*u.cy-1],l),this.narrow.bind(),a.activeTexture(a.TEXTURE0),a.bindTexture(a.TEXTURE_2D,this.nearness.texture),this.narrowProgram.use().integer("nearness",0).numbers("depth",0).numbers("scale",this.nearnessFactor(e)/l),a.drawArrays(a.TRIANGLES,0,3),a.bindFramebuffer(a.FRAMEBUFFER,this.hidesFrame),a.framebufferTextureLayer(a.FRAMEBUFFER,a.COLOR_ATTACHMENT0,this.hides,0,d),a.bindTexture(a.TEXTURE_2D,this.narrow.texture),this.widenProgram.use().integer("narrow",0).numbers("depth",0),a.drawArrays(a.TRIANGLES,0,3)}a.bindFramebuffer(a.FRAMEBUFFER,this.frame),a.framebufferTextureLayer(a.FRAMEBUFFER,a.COLOR_ATTACHMENT0,this.texture,0,r),a.viewport(s,i,n,h),a.colorMask(!1,!1,!1,!0),a.enable(a.BLEND),a.blendFunc(a.ZERO,a.SRC_ALPHA),a.activeTexture(a.TEXTURE0),a.bindTexture(a.TEXTURE_2D_ARRAY,this.hides),this.openProgram.use().integer("hides",0).numbers("depth",0).numbers("area",s,i,1/n,1/h).numbers("layer",d),a.drawArrays(a.TRIANGLES,0,3),a.disable(a.BLEND),a.colorMask(!0,!0,!0,!0)}};var ee=[3,4,5,6,7,8,10,k],Z=class{constructor(e,t,r,s){this.header=t;this.geometry=null;this.fieldPrograms=[];this.pulled=[];this.pushed=[];this.corners=new Float32Array(12);this.data=new Float32Array(4080);let i=e.getContext("webgl2",{alpha:!0,antialias:!1,depth:!1,stencil:!1,powerPreference:"high-performance"});if(!i)throw new Error("This browser has no WebGL 2, which draws the pictures.");this.gl=i,this.canDrawFloats=i.getExtension("EXT_color_buffer_float")!==null||i.getExtension("EXT_color_buffer_half_float")!==null,this.cameras=le(r,t.views),this.field=r.has("triangles")?new G(r,this.cameras):new W(t,this.cameras),this.pictures=new Y(i,t,this.cameras,()=>this.geometry,s),this.findOpen=new T(i,_,fe),this.open=new M(i,i.R8,i.NEAREST),this.fill=new T(i,pe,ve),this.drawn=new M(i,i.RGBA8,i.NEAREST),this.nothing=i.createVertexArray(),this.pull=new T(i,_,ye),this.push=new T(i,_,xe),this.depth=new M(i,i.DEPTH_COMPONENT24,i.NEAREST),this.views=i.createBuffer(),i.bindBuffer(i.UNIFORM_BUFFER,this.views),i.bufferData(i.UNIFORM_BUFFER,this.data.byteLength,i.DYNAMIC_DRAW)}setGeometry(e,t){e.geometry&&(this.geometry=new $(this.gl,e.geometry,t))}pointAt(e,t,r){let s=[(t-.5*e.width)/e.focalPx,(r-.5*e.height)/e.focalPx,1],i=B(e.camFromWorld,s),n=p(V(e.eye),-1),h=f(e.eye)/Math.max(y(i,n),.001);return E(e.eye,p(i,this.geometry?.hit(e.eye,i)??h))}put(e,t,r){let s=this.pictures.place(t),i=this.cameras[t],n=24*e,h=i.camFromWorld,a=r.camFromWorld,d=E(R(h,r.eye),i.translation);for(let c=0;c<3;++c){for(let m=0;m<3;++m)this.data[n+4*c+m]=h[3*c]*a[3*m]+h[3*c+1]*a[3*m+1]+h[3*c+2]*a[3*m+2];this.data[n+4*c+3]=d[c]}for(let c=0;c<4;++c){let m=this.data[n+8+c];this.data[n+c]=i.fx*this.data[n+c]+i.cx*m,this.data[n+4+c]=i.fy*this.data[n+4+c]+i.cy*m}let u=this.header.feather*Math.min(i.width,i.height),l=R(a,w(i.center,r.eye));this.data.set([i.width/u,i.height/u,s.layer,this.pictures.nearnessFactor(t)],n+12),this.data.set([s.scaleX,s.scaleY,s.offsetX,s.offsetY],n+16),this.data.set([...l,0],n+20)}uploadViews(e){let t=this.gl;t.bindBuffer(t.UNIFORM_BUFFER,this.views),t.bufferData(t.UNIFORM_BUFFER,this.data.byteLength,t.DYNAMIC_DRAW),t.bufferSubData(t.UNIFORM_BUFFER,0,this.data,0,24*e),t.bindBufferBase(t.UNIFORM_BUFFER,0,this.views)}near(e){return .02*f(e.eye)}drawDepth(e){let t=this.gl;if(this.depth.bind(),!this.geometry)return t.clear(t.DEPTH_BUFFER_BIT),!1;if(this.geometry.drawNearness(e.camFromWorld,p(R(e.camFromWorld,e.eye),-1),[2*e.focalPx/e.width,-2*e.focalPx/e.height,0,0],this.near(e)),!this.canDrawFloats)return!1;let r=[];for(let s=e.width+1>>1,i=e.height+1>>1;s>1||i>1;)r.push([s=s+1>>1,i=i+1>>1]);for(;this.pulled.length<r.length;)this.pulled.push(new M(t,t.R16F,t.NEAREST)),this.pushed.push(new M(t,t.R16F,t.LINEAR));t.activeTexture(t.TEXTURE0),this.pull.use().integer("finer",0).numbers("depth",0),r.forEach(([s,i],n)=>{let h=this.pulled[n];h.resize(s,i),this.pull.integer("ofNearness",n===0?1:0),h.bind(),t.bindTexture(t.TEXTURE_2D,n===0?this.depth.texture:this.pulled[n-1].texture),t.drawArrays(t.TRIANGLES,0,3)}),this.push.use().integer("coarser",0).integer("pulled",1).numbers("depth",0);for(let s=r.length-2;s>=0;--s){let i=this.pushed[s];i.resize(...r[s]),i.bind(),t.activeTexture(t.TEXTURE0),t.bindTexture(t.TEXTURE_2D,s===r.length-2?this.pulled[s+1].texture:this.pushed[s+1].texture),t.activeTexture(t.TEXTURE1),t.bindTexture(t.TEXTURE_2D,this.pulled[s].texture),t.drawArrays(t.TRIANGLES,0,3)}return r.length>1}setPixels(e,t,r,s){let i=this.gl,n=this.near(t),h=f(t.eye),a=p(R(t.camFromWorld,t.eye),-1/h**2);e.use().integer("pictures",0).integer("nearness",1).integer("holes",2).numbers("masks",this.pictures.masks&&r===0?1:0).numbers("camera",.5*t.width,.5*t.height,1/t.focalPx,1/n).numbers("plane",...a,.001/h).numbers("focusInverse",r).numbers("holesScale",s?1/n:0),i.activeTexture(i.TEXTURE0),i.bindTexture(i.TEXTURE_2D_ARRAY,this.pictures.texture),i.activeTexture(i.TEXTURE1),i.bindTexture(i.TEXTURE_2D,this.depth.texture),i.activeTexture(i.TEXTURE2),i.bindTexture(i.TEXTURE_2D,s?this.pushed[0].texture:this.depth.texture)}draw(e,t){let r=this.gl;r.disable(r.BLEND),this.depth.resize(e.width,e.height);let s=t?!1:this.drawDepth(e),i=t?this.focusDepth(e,t):0,n=t?this.viewsThrough(e,t):[];return n.length>0&&t?this.drawAperture(e,t,n,i):this.drawField(e,t?1/i:0,s)}focusDepth(e,t){let r=R(e.camFromWorld,w(t.focus,e.eye));return Math.max(r[2],.001*f(r),1e-9)}viewsThrough(e,t){let r=this.cameras.map((i,n)=>{let h=R(e.camFromWorld,w(i.center,e.eye));return[Math.hypot(h[0],h[1]),n]}).filter(([i,n])=>i<1.2*t.radius&&this.pictures.place(n)).sort((i,n)=>i[0]-n[0]).map(([,i])=>i);return r.length>=4?r.slice(0,170):[]}drawAperture(e,t,r,s){r.forEach((h,a)=>this.put(a,h,e)),this.uploadViews(r.length);let i=this.gl,n=this.apertureProgram??=new T(i,_,be);return this.setPixels(n,e,1/s,!1),i.bindFramebuffer(i.FRAMEBUFFER,null),i.viewport(0,0,e.width,e.height),n.integer("count",r.length).numbers("inverseRadius",1/t.radius).numbers("depth",0),i.drawArrays(i.TRIANGLES,0,3),r}nearestViews(e,t){return this.byAngle(e).filter(r=>this.pictures.place(r)).slice(0,t)}byAngle(e){return this.cameras.map((t,r)=>[D(t.center,e.eye),r]).sort((t,r)=>t[0]-r[0]).map(([,t])=>t)}drawField(e,t,r){let s=this.gl,i=this.nearestViews(e,16),n=new Map;this.drawn.resize(e.width,e.height),this.drawn.bind(),s.clearColor(0,0,0,0),s.clear(s.COLOR_BUFFER_BIT),s.bindVertexArray(this.nothing);let h=this.field.place(e),a=h.map(l=>l.fans.filter(c=>this.pictures.place(c.view))),d=-1;return h.forEach((l,c)=>{for(let b of l.fans)n.set(b.view,(n.get(b.view)??0)+Math.max(0,b.numerator[2])/Math.max(l.denominator[2],1e-9));let m=a[c];if(m.length===0)return;let v=ee.findIndex(b=>b>=m.length),g=this.fieldPrograms[v]??=new T(s,de,me(ee[v]));v!==d&&this.setPixels(g,e,t,r),d=v;let P=ee[v];for(let b=0;b<P;++b){let z=m[Math.min(b,m.length-1)];this.put(b,z.view,e),this.data.set(b<m.length?z.numerator:[0,0,0],4*(6*b+5))}l.corners.forEach((b,z)=>this.corners.set([b[0],b[1],0,b[2]],4*z)),g.vectors("own",this.data.subarray(0,24*P)).vectors("corners",this.corners).numbers("denominator",...l.denominator),s.drawArrays(s.TRIANGLES,0,3)}),i.forEach((l,c)=>this.put(c,l,e)),this.uploadViews(i.length),this.open.resize(Math.ceil(e.width/U),Math.ceil(e.height/U)),this.open.bind(),s.activeTexture(s.TEXTURE3),s.bindTexture(s.TEXTURE_2D,this.drawn.texture),this.findOpen.use().integer("drawn",3).numbers("depth",0),s.drawArrays(s.TRIANGLES,0,3),this.drawn.copyToScreen(),this.setPixels(this.fill,e,t,r),s.activeTexture(s.TEXTURE3),s.bindTexture(s.TEXTURE_2D,this.drawn.texture),s.activeTexture(s.TEXTURE4),s.bindTexture(s.TEXTURE_2D,this.open.texture),this.fill.integer("drawn",3).integer("openTiles",4).integer("filling",i.length),s.drawArraysInstanced(s.TRIANGLES,0,6,this.open.width*this.open.height),s.bindVertexArray(null),[...[...n].sort((l,c)=>c[1]-l[1]).map(([l])=>l),...i.filter(l=>!n.has(l)).slice(0,4)]}textureBytes(e,t){return this.pictures.bytes+8*e*t+4*Math.ceil(e*t/3)}};function F(o){return document.getElementById(o)}var te=class{constructor(){this.canvas=F("picture");this.progress=F("progress");this.status=F("status");this.apertureSlider=F("aperture");this.focusSlider=F("focus");this.lens=F("lens");this.help=F("help");this.renderer=null;this.header=null;this.orbit=null;this.waiting=[];this.pace=new H;this.focus=[0,0,0];this.shown=[];this.asked=!1;this.movedAt=-1/0;this.hasMoved=!1;this.moves=!1;this.lastFrameAt=0;this.later=0;this.loadedBytes=0;this.hasTurned=!1;this.figures={frames:0,firstPictureMs:0,complete:!1,scale:1,failed:""};ie((e,t)=>this.receive(e,t)),this.connect()}receive(e,t){try{if(e.kind==="scene")this.begin(e,t);else if(!this.renderer)this.waiting.push([e,t]);else if(e.kind==="geometry")this.renderer.setGeometry(e,new C(e.arrays,t));else for(let[r,s,i]of e.views){let n=t.slice(s,s+i);e.kind==="fine"?this.renderer.pictures.addFine(r,n):this.renderer.pictures.addSmall(r,n).catch(h=>this.fail(h))}e.kind==="fine"?this.fetch():e.kind==="geometry"&&this.draw()}catch(r){this.fail(r)}}begin(e,t){this.header=e,this.renderer=new Z(this.canvas,e,new C(e.arrays,t),i=>this.arrived(i)),e.masks&&this.renderer.pictures.noteMasks(),this.orbit=new N(e,this.renderer.field);let{width:r,height:s}=this.size(1);this.orbit.reset(r,s);for(let[i,n]of this.waiting.splice(0))this.receive(i,n);new ResizeObserver(()=>{let i=this.size(1);this.orbit?.setZoom(this.orbit.zoom,i.width,i.height),this.draw()}).observe(this.canvas),this.canvas.addEventListener("webglcontextlost",()=>this.say("The device took the graphics away. Reload the page.")),addEventListener("load",()=>{this.loadRest(e)}),document.readyState==="complete"&&this.loadRest(e)}async loadRest(e){let t=e.files.reduce((i,[,n])=>i+n,0),r=[...e.files],s=async()=>{for(let i=r.shift();i;i=r.shift()){await se(i[0]),this.loadedBytes+=i[1];let n=t>0?this.loadedBytes/t:1;this.progress.style.setProperty("--share",n.toFixed(3)),this.progress.setAttribute("aria-valuenow",String(Math.round(100*n)))}};try{await Promise.all([s(),s()]),this.progress.classList.add("done"),this.progress.setAttribute("aria-hidden","true"),this.status.textContent="All pictures are loaded."}catch(i){this.progress.classList.add("done"),this.say("Some pictures could not be loaded. Reload the page to try again."),console.warn(i)}this.draw()}say(e){let t=F("message");t.textContent=e,t.hidden=!1}fail(e){this.figures.failed=String(e),this.say(e instanceof Error&&e.message.startsWith("This browser")?e.message:"The light field cannot be shown here."),console.error(e)}size(e){let r=this.canvas.clientWidth||1,s=this.canvas.clientHeight||1,i=Math.min(devicePixelRatio||1,2,Math.sqrt(26e5/(r*s)));return{width:Math.max(1,Math.round(r*i*e)),height:Math.max(1,Math.round(s*i*e))}}get aperture(){let e=Number(this.apertureSlider.value);if(!this.header||!this.orbit||e<=0)return null;let t=f(this.orbit.eye),r=(this.header.spacing||.1)*t;return{radius:r*1.3*(.35*t/(1.3*r))**((e-1)/99),focus:this.focus}}draw(){this.asked||!this.renderer||(this.asked=!0,requestAnimationFrame(e=>this.frame(e)))}frame(e){if(this.asked=!1,!this.renderer||!this.orbit||this.renderer.pictures.shown===0)return;let r=this.hasMoved||e-this.movedAt<180;this.hasMoved=!1;let s=r?this.pace.size:1,{width:i,height:n}=this.size(s);(this.canvas.width!==i||this.canvas.height!==n)&&(this.canvas.width=i,this.canvas.height=n),this.shown=this.renderer.draw(this.orbit.camera(i,n),this.aperture),this.fetch(),this.figures.frames===0&&(this.figures.firstPictureMs=performance.now(),document.body.classList.add("shows")),++this.figures.frames,this.figures.scale=s,this.figures.complete=this.progress.classList.contains("done")&&!this.renderer.pictures.waits(this.shown),r&&(this.moves&&this.pace.note(e-this.lastFrameAt),this.draw()),this.moves=r,this.lastFrameAt=e}fetch(){if(!this.renderer||!this.orbit)return;let{pictures:e}=this.renderer,t=Math.floor(.8*e.fineViews),r=this.renderer.byAngle(this.orbit.camera(1,1)).slice(0,t);e.want([...this.shown,...r.filter(s=>!this.shown.includes(s))])}arrived(e){if(this.figures.frames>0&&!this.shown.includes(e))return this.fetch();let t=this.figures.frames===0?0:250,r=this.lastFrameAt+t-performance.now();r<=0?this.draw():this.later||(this.later=setTimeout(()=>{this.later=0,this.draw()},r)),this.fetch()}moved(){this.movedAt=performance.now(),this.hasMoved=!0,this.draw()}turn(e,t){this.orbit?.turn(e,t)&&this.moved(),this.hasTurned||(this.hasTurned=!0,document.body.classList.add("used"))}zoomBy(e){if(!this.orbit)return;let{width:t,height:r}=this.size(1);this.orbit.setZoom(this.orbit.zoom*e,t,r),this.showZoom(),this.moved()}showZoom(){if(!this.orbit)return;let{width:e,height:t}=this.size(1);F("zoom_in").disabled=this.orbit.zoom>=K-1e-6,F("zoom_out").disabled=this.orbit.zoom<=this.orbit.leastZoom(e,t)+1e-6}reset(){if(!this.orbit)return;let{width:e,height:t}=this.size(1);this.orbit.reset(e,t),this.apertureSlider.value="0",this.setFocus([0,0,0]),this.showZoom(),this.moved()}setFocus(e){if(this.focus=e,!this.orbit||!this.header)return;let t=this.orbit.camera(1,1),r=R(t.camFromWorld,w(e,t.eye))[2];this.focusSlider.value=String(100*(r/f(t.eye)-.6)/.9),this.draw()}focusAt(e,t){if(!this.orbit||!this.renderer||!this.aperture)return;let r=this.canvas.getBoundingClientRect(),s=this.orbit.camera(Math.round(r.width),Math.round(r.height));this.setFocus(this.renderer.pointAt(s,e-r.left,t-r.top));let i=F("mark");i.style.left=`${e-r.left}px`,i.style.top=`${t-r.top}px`,i.classList.remove("seen"),i.offsetWidth,i.classList.add("seen")}focusFromSlider(){if(!this.orbit)return;let e=this.orbit.camera(1,1),t=f(e.eye)*(.6+.9*Number(this.focusSlider.value)/100);this.focus=E(e.eye,B(e.camFromWorld,p([0,0,1],t))),this.moved()}step(e,t){e.value=String(L(Number(e.value)+t,0,100)),e.dispatchEvent(new Event("input"))}toggleLens(e=this.lens.hidden){this.lens.hidden=!e,F("depth_of_field").setAttribute("aria-expanded",String(e)),document.body.classList.add("used"),e&&Number(this.apertureSlider.value)===0&&this.step(this.apertureSlider,35),e&&this.apertureSlider.focus()}async toggleFullscreen(){document.fullscreenElement?await document.exitFullscreen():await document.documentElement.requestFullscreen()}key(e){if(this.help.open)return!1;let t=e.shiftKey?.01:.05,r={ArrowLeft:()=>this.turn(-t,0),ArrowRight:()=>this.turn(t,0),ArrowUp:()=>this.turn(0,t),ArrowDown:()=>this.turn(0,-t),"+":()=>this.zoomBy(1.1),"=":()=>this.zoomBy(1.1),"-":()=>this.zoomBy(1/1.1),Home:()=>this.reset(),0:()=>this.reset(),o:()=>this.step(this.apertureSlider,5),i:()=>this.step(this.apertureSlider,-5),u:()=>this.step(this.focusSlider,3),j:()=>this.step(this.focusSlider,-3),f:()=>{this.toggleFullscreen().catch(()=>{})},"?":()=>this.help.showModal(),Escape:()=>this.toggleLens(!1)},s=r[e.key]??r[e.key.toLowerCase()];return e.key==="Escape"&&this.lens.hidden?!1:(s?.(),s!==void 0)}connect(){he(this.canvas,{turn:(r,s)=>this.turn(r,s),zoomBy:r=>this.zoomBy(r),focusAt:(r,s)=>this.focusAt(r,s),key:r=>this.key(r),rest:()=>this.draw()});let e=(r,s)=>F(r).addEventListener("click",s);e("zoom_in",()=>this.zoomBy(1.25)),e("zoom_out",()=>this.zoomBy(1/1.25)),e("again",()=>this.reset()),e("depth_of_field",()=>this.toggleLens()),e("show_help",()=>this.help.showModal()),e("close_help",()=>this.help.close()),this.help.addEventListener("click",r=>{r.target===this.help&&this.help.close()});let t=F("fullscreen");document.fullscreenEnabled?(t.addEventListener("click",()=>{this.toggleFullscreen().catch(()=>{})}),document.addEventListener("fullscreenchange",()=>t.setAttribute("aria-pressed",String(document.fullscreenElement!==null)))):t.hidden=!0,this.apertureSlider.addEventListener("input",()=>this.moved()),this.focusSlider.addEventListener("input",()=>this.focusFromSlider())}lookFrom(e,t){this.orbit&&(this.orbit.eye=e,this.orbit.zoom=t,this.draw())}openLens(e){this.apertureSlider.value=String(e),this.draw()}textureBytes(){let{width:e,height:t}=this.size(1);return this.renderer?.textureBytes(e,t)??0}};window.ulfPage=new te;})();
