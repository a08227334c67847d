"use strict";(()=>{function Le(a){let e=atob(a),t=new Uint8Array(e.length);for(let r=0;r<e.length;++r)t[r]=e.charCodeAt(r);return t}var I=class{constructor(e,t){this.places=e;this.bytes=t}has(e){return e in this.places}place(e){let t=this.places[e];if(!t)throw new Error(`the data have no ${e}`);return t}f32(e){let[,t,r]=this.place(e);return new Float32Array(this.bytes.buffer,t,r)}integers(e){let[t,r,s]=this.place(e);return t==="u16"?new Uint16Array(this.bytes.buffer,r,s):new Uint32Array(this.bytes.buffer,r,s)}};function oe(a){window.ulfData=(e,t)=>a(e,Le(t))}async function ae(a){for(let t=1;;++t)try{await new Promise((r,s)=>{let i=document.createElement("script");i.src=a,i.onload=()=>{i.remove(),r()},i.onerror=()=>{i.remove(),s(new Error(`${a} could not be loaded`))},document.head.append(i)});return}catch(r){if(t===4)throw r;await new Promise(s=>setTimeout(s,500*2**t))}}var x=(a,e)=>a[0]*e[0]+a[1]*e[1]+a[2]*e[2],E=(a,e)=>[a[1]*e[2]-a[2]*e[1],a[2]*e[0]-a[0]*e[2],a[0]*e[1]-a[1]*e[0]],g=(a,e)=>[a[0]*e,a[1]*e,a[2]*e],T=(a,e)=>[a[0]+e[0],a[1]+e[1],a[2]+e[2]],y=(a,e)=>[a[0]-e[0],a[1]-e[1],a[2]-e[2]],p=a=>Math.hypot(a[0],a[1],a[2]),M=a=>g(a,1/p(a)),S=(a,e,t)=>Math.min(Math.max(a,e),t),D=(a,e)=>Math.atan2(p(E(a,e)),x(a,e)),V=(a,e)=>[a[0]*e[0]+a[1]*e[1]+a[2]*e[2],a[3]*e[0]+a[4]*e[1]+a[5]*e[2],a[6]*e[0]+a[7]*e[1]+a[8]*e[2]],U=(a,e)=>[a[0]*e[0]+a[3]*e[1]+a[6]*e[2],a[1]*e[0]+a[4]*e[1]+a[7]*e[2],a[2]*e[0]+a[5]*e[1]+a[8]*e[2]];function K(a,e,t){let r=Math.cos(t);return T(T(g(a,r),g(E(e,a),Math.sin(t))),g(e,x(e,a)*(1-r)))}function he(a,e){let t=M(g(a,-1)),r=M(E(t,e)),s=E(t,r);return[...r,...s,...t]}var j=2.5,Se=1.1,le=.035;function ce(a,e,t){let r=e/a.width,s=t/a.height;return Math.min(r,s)/Math.max(r,s)}function Q(a,e,t,r,s){let i=e/Math.sqrt(Math.max(t**2-e**2,1e-12)),n=a.focal*Math.max(r/a.width,s/a.height);return S(Math.min(r,s)/(2*1.25*i*n),ce(a,r,s),Se)}var k=class{constructor(e,t){this.header=e;this.field=t;this.zoom=1;this.eye=e.eye,this.up=M(e.up)}get lens(){let[e,t,r]=this.header.lens;return{width:e,height:t,focal:r}}leastZoom(e,t){return ce(this.lens,e,t)}setZoom(e,t,r){this.zoom=S(e,this.leastZoom(t,r),j)}reset(e,t){this.eye=this.header.eye,this.zoom=Q(this.lens,this.header.radius,p(this.eye),e,t)}camera(e,t){let{lens:r}=this,s=this.zoom*r.focal*Math.max(e/r.width,t/r.height);return{eye:this.eye,camFromWorld:he(this.eye,this.up),focalPx:s,width:e,height:t}}turn(e,t){let r=Math.max(1,Math.ceil(Math.hypot(e,t)/.02)),s=!1;for(let i=0;i<r;++i){let n=[e/r,t/r];s=this.step(...n)||this.step(n[0],0)||this.step(0,n[1])||s}return s}step(e,t){if(e===0&&t===0)return!1;let r=D(this.eye,this.up),s=S(r-t,Math.min(le,r),Math.max(Math.PI-le,r)),i=M(E(this.up,this.eye)),n=K(this.eye,i,s-r);return n=K(n,this.up,e),!this.field.inside(n)&&this.field.inside(this.eye)?!1:(this.eye=g(M(n),p(this.header.eye)),!0)}};var O=[1,.84,.71,.59,.5,.42,.35],J=.5,ue=34.5,Be=17.5,H=class{constructor(){this.index=0;this.smoothedMs=0;this.frames=0}get size(){return O[this.index]}get simple(){return this.size<=J}note(e){this.smoothedMs=this.frames===0?e:.6*this.smoothedMs+.4*e,++this.frames;let t=3,r=30;if(this.frames>=t&&this.smoothedMs>ue&&this.index+1<O.length){let s=this.size*Math.sqrt(ue/this.smoothedMs),i=O.findIndex(n=>n<=s);this.change(i<0?O.length-1:Math.max(i,this.index+1))}else this.frames>=r&&this.smoothedMs<Be&&this.index>0&&this.change(this.index-1)}change(e){this.index=e,this.frames=0}};function de(a,e){let t=new Map,r={x:0,y:0,time:0,travelled:0},s=0,i=()=>{let[o,h]=[...t.values()];return o&&h?Math.hypot(o.x-h.x,o.y-h.y):0};a.addEventListener("pointerdown",o=>{o.button===0&&(a.setPointerCapture(o.pointerId),t.set(o.pointerId,{x:o.clientX,y:o.clientY}),r={x:o.clientX,y:o.clientY,time:o.timeStamp,travelled:t.size>1?6:0},s=i(),a.classList.add("held"))}),a.addEventListener("pointermove",o=>{let h=t.get(o.pointerId);if(!h)return;let d=o.clientX-h.x,m=o.clientY-h.y;if(h.x=o.clientX,h.y=o.clientY,r.travelled=Math.max(r.travelled,Math.hypot(o.clientX-r.x,o.clientY-r.y)),t.size===1)r.travelled>=6&&e.turn(-d*.005,m*.005);else{let c=i();s>0&&c>0&&e.zoomBy(c/s),s=c}});let n=o=>{t.delete(o.pointerId)&&(s=i(),!(t.size>0)&&(a.classList.remove("held"),e.rest(),o.type==="pointerup"&&r.travelled<6&&o.timeStamp-r.time<350&&e.focusAt(o.clientX,o.clientY)))};a.addEventListener("pointerup",n),a.addEventListener("pointercancel",n),a.addEventListener("wheel",o=>{o.preventDefault();let h=o.deltaMode===1?16:o.deltaMode===2?400:1;e.zoomBy(Math.exp(-o.deltaY*h*.0015))},{passive:!1}),window.addEventListener("keydown",o=>{o.ctrlKey||o.metaKey||o.altKey||o.target instanceof HTMLInputElement&&o.key.startsWith("Arrow")||e.key(o)&&o.preventDefault()})}var G=12;function me(a,e){let t=a.f32("cameras"),r=[];for(let s=0;s<e;++s){let i=h=>t[18*s+h],n=[i(6),i(7),i(8),i(10),i(11),i(12),i(14),i(15),i(16)],o=[i(9),i(13),i(17)];r.push({fx:i(0),fy:i(1),cx:i(2),cy:i(3),width:i(4),height:i(5),camFromWorld:n,translation:o,center:g(U(n,o),-1)})}return r}var De=.001;function ee(a,e,t){let r=E(e,t),s=x(a,r);return Math.abs(s)>1e-15*p(a)*p(e)*p(t)?[g(r,1/s),g(E(t,a),1/s),g(E(a,e),1/s)]:null}function Ue(a,e){let t=[0,0,0,0,0],r=a.map(s=>{let i=2*e.focalPx*s[0]/e.width,n=-2*e.focalPx*s[1]/e.height;return s[2]<=0&&++t[0],i>s[2]&&++t[1],-i>s[2]&&++t[2],n>s[2]&&++t[3],-n>s[2]&&++t[4],[i,n,s[2]]});return t.includes(3)?null:r}function fe(a,e,t){let r=Math.max(...e.map(p)),s=e.map(n=>g(n,1/r)),i=t;return i.length>G&&(i=[...i].sort((n,o)=>o.weights[0]+o.weights[1]+o.weights[2]-n.weights[0]-n.weights[1]-n.weights[2]).slice(0,G)),{corners:a,denominator:T(T(s[0],s[1]),s[2]),fans:i.map(({view:n,weights:o})=>({view:n,numerator:T(T(g(s[0],o[0]),g(s[1],o[1])),g(s[2],o[2]))}))}}var W=class{constructor(e,t){this.cameras=t;this.positions=[];this.viewsOfVertex=[];let r=e.f32("positions");for(let l=0;l<r.length;l+=3)this.positions.push([r[l],r[l+1],r[l+2]]);let s=l=>{let u=e.integers(l),f=[];for(let v=0;v<u.length;v+=3)f.push([u[v],u[v+1],u[v+2]]);return f},i=s("hull"),n=[[1,0,0],[0,1,0],[0,0,1]];this.plain={triangles:i,entries:i.map(l=>l.map((u,f)=>({vertex:u,weights:n[f]})))},this.subdivided={triangles:s("triangles"),entries:[]};let o=e.integers("firstWeight"),h=e.integers("weightVertex"),d=e.f32("weight");for(let l of this.subdivided.triangles){let u=new Map;l.forEach((f,v)=>{for(let b=o[f];b<o[f+1];++b){let _=u.get(h[b])??[0,0,0];_[v]+=d[b],u.set(h[b],_)}}),this.subdivided.entries.push([...u].map(([f,v])=>({vertex:f,weights:v})))}let m=e.integers("firstViewOfVertex"),c=e.integers("viewOfVertex");for(let l=0;l+1<m.length;++l)this.viewsOfVertex.push(Array.from(c.subarray(m[l],m[l+1])))}inside(e){return this.plain.triangles.some(t=>{let r=t.map(s=>this.positions[s]);return[0,1,2].every(s=>x(e,E(r[s],r[(s+1)%3]))>=0)})}offTheMesh(e,t){let r=M(e);for(let s=t.length-1;s>=0;--s){let[i,n,o]=t[s].map(b=>this.positions[b]),h=ee(i,n,o);if(!h||h.some(b=>x(b,r)<0))continue;let d=y(n,i),m=y(o,n),c=y(i,o),l=M(E(d,g(c,-1))),u=De*Math.min(p(d),p(m),p(c)),f=-x(l,y(i,e)),v=x(l,r);return Math.abs(f)>=u||v<=0?e:T(e,g(r,((f<0?-u:u)-f)/v))}return e}viewAt(e,t){let r=this.viewsOfVertex[e],s=r[0];for(let i of r)Math.abs(p(this.cameras[i].center)-t)<Math.abs(p(this.cameras[s].center)-t)&&(s=i);return s}place(e,t){let{triangles:r,entries:s}=t?this.plain:this.subdivided,i=this.offTheMesh(e.eye,r),n=p(e.eye),o=this.positions.map(d=>V(e.camFromWorld,y(d,i))),h=[];return r.forEach((d,m)=>{let c=d.map(f=>o[f]);x(c[0],E(c[1],c[2]))>0&&(c=c.map(f=>g(f,-1)));let l=Ue(c,e);if(!l)return;let u=ee(...c);u&&h.push(fe(l,u,s[m].map(({vertex:f,weights:v})=>({view:this.viewAt(f,n),weights:v}))))}),h}},X=class{constructor(e,t){this.header=e;this.cameras=t}weightsAt(e,t){let r=y(t,e),s=[];this.cameras.forEach((c,l)=>{let u=T(V(c.camFromWorld,e),c.translation),f=c.fx*u[0]/u[2]+c.cx,v=c.fy*u[1]/u[2]+c.cy;if(u[2]<=0||f<0||v<0||f>1||v>1)return;let b=y(c.center,e);s.push([D(r,b)+this.header.lumigraphResolution*Math.max(0,p(b)/p(r)-1),l])}),s.sort((c,l)=>c[0]-l[0]);let i=Math.max(1,this.header.lumigraphViews),n=s.slice(0,i),o=new Map;if(n.length===0)return o;let h=n[n.length-1][0],d=s.length>i?Math.max(s[i][0],1.001*h):1.1*h;if(n[0][0]<=1e-6)return o.set(n[0][1],1);let m=0;for(let[c]of n)m+=Math.max(0,1-c/d)/c;for(let[c,l]of n)o.set(l,Math.max(0,1-c/d)/c/m);return o}place(e,t){let i=p(e.eye),n=g(e.eye,-1/i),o=[];for(let m=0;m<=6;++m)for(let c=0;c<=8;++c){let l=[2*c/8-1,2*m/6-1,1],u=[l[0]*e.width/(2*e.focalPx),-l[1]*e.height/(2*e.focalPx),1],f=U(e.camFromWorld,u),v=Math.max(x(f,n),.001);o.push({ray:u,clip:l,weights:this.weightsAt(T(e.eye,g(f,i/v)),e.eye)})}let h=[],d=(m,c,l)=>{let u=[o[m],o[c],o[l]],f=ee(u[0].ray,u[1].ray,u[2].ray);if(!f)return;let v=new Map;u.forEach((b,_)=>{for(let[w,C]of b.weights){let ne=v.get(w)??[0,0,0];ne[_]=C,v.set(w,ne)}}),h.push(fe(u.map(b=>b.clip),f,[...v].map(([b,_])=>({view:b,weights:_}))))};for(let m=0;m<6;++m)for(let c=0;c<8;++c){let l=m*9+c;d(l,l+1,l+8+1),d(l+1,l+8+2,l+8+1)}return h}inside(e){let t=S(this.header.spacing||.15,.02,.3);return this.cameras.some(r=>D(r.center,e)<=t)}};var $=class{constructor(e,t,r,s){this.gl=e;this.program=t;this.header=r;this.places=s.integers("places"),this.corners=s.integers("corners"),this.count=this.corners.length,this.cornerType=this.corners instanceof Uint16Array?e.UNSIGNED_SHORT:e.UNSIGNED_INT,this.vertices=e.createVertexArray(),e.bindVertexArray(this.vertices),e.bindBuffer(e.ARRAY_BUFFER,e.createBuffer());let i=new Uint16Array(this.places.length/3*4);for(let n=0;3*n<this.places.length;++n)i.set(this.places.subarray(3*n,3*n+3),4*n);e.bufferData(e.ARRAY_BUFFER,i,e.STATIC_DRAW),e.enableVertexAttribArray(0),e.vertexAttribPointer(0,3,e.UNSIGNED_SHORT,!1,8,0),e.bindBuffer(e.ELEMENT_ARRAY_BUFFER,e.createBuffer()),e.bufferData(e.ELEMENT_ARRAY_BUFFER,this.corners,e.STATIC_DRAW),e.bindVertexArray(null)}drawNearness(e,t,r,s){let i=this.gl,n=e,o=t;i.enable(i.DEPTH_TEST),i.depthFunc(i.LESS),i.clear(i.DEPTH_BUFFER_BIT),this.program.use().numbers("low",...this.header.low).numbers("step",...this.header.step).numbers("row0",n[0],n[1],n[2],o[0]).numbers("row1",n[3],n[4],n[5],o[1]).numbers("row2",n[6],n[7],n[8],o[2]).numbers("lens",...r).numbers("near",s),i.bindVertexArray(this.vertices),i.drawElements(i.TRIANGLES,this.count,this.cornerType,0),i.bindVertexArray(null),i.disable(i.DEPTH_TEST)}vertex(e){let{low:t,step:r}=this.header;return[0,1,2].map(s=>t[s]+r[s]*this.places[3*e+s])}hit(e,t){let r=null;for(let s=0;s<this.count;s+=3){let i=this.vertex(this.corners[s]),n=y(this.vertex(this.corners[s+1]),i),o=y(this.vertex(this.corners[s+2]),i),h=E(t,o),d=x(n,h);if(d===0)continue;let m=y(e,i),c=x(m,h)/d;if(c<0||c>1)continue;let l=E(m,n),u=x(t,l)/d;if(u<0||c+u>1)continue;let f=x(o,l)/d;f>0&&(r===null||f<r)&&(r=f)}return r}};var A=class{constructor(e,t,r){this.gl=e;this.places=new Map;this.isChecked=!1;this.program=e.createProgram();for(let[s,i]of[[e.VERTEX_SHADER,t],[e.FRAGMENT_SHADER,r]]){let n=e.createShader(s);if(!n)throw new Error("the graphics were lost");e.shaderSource(n,i),e.compileShader(n),e.attachShader(this.program,n),e.deleteShader(n)}e.linkProgram(this.program)}check(){let{gl:e,program:t}=this;if(this.isChecked=!0,!e.getProgramParameter(t,e.LINK_STATUS)&&!e.isContextLost()){let s=(e.getAttachedShaders(t)??[]).map(i=>e.getShaderInfoLog(i));throw new Error(`shaders: ${[...s,e.getProgramInfoLog(t)].join(" ")}`)}let r=e.getUniformBlockIndex(t,"Views");r!==e.INVALID_INDEX&&e.uniformBlockBinding(t,r,0)}use(){return this.isChecked||this.check(),this.gl.useProgram(this.program),this}at(e){return this.places.has(e)||this.places.set(e,this.gl.getUniformLocation(this.program,e)),this.places.get(e)??null}integer(e,t){return this.gl.uniform1i(this.at(e),t),this}vectors(e,t){return this.gl.uniform4fv(this.at(e),t),this}numbers(e,...t){let r=this.at(e);return t.length===1?this.gl.uniform1f(r,t[0]):t.length===3?this.gl.uniform3fv(r,t):this.gl.uniform4fv(r,t),this}};function Y(a,e,t){let r=a.createTexture();return a.bindTexture(e,r),a.texParameteri(e,a.TEXTURE_MIN_FILTER,t),a.texParameteri(e,a.TEXTURE_MAG_FILTER,t),a.texParameteri(e,a.TEXTURE_WRAP_S,a.CLAMP_TO_EDGE),a.texParameteri(e,a.TEXTURE_WRAP_T,a.CLAMP_TO_EDGE),r}var P=class{constructor(e,t,r){this.gl=e;this.format=t;this.width=0;this.height=0;this.texture=Y(e,e.TEXTURE_2D,r),this.frame=e.createFramebuffer()}get isDepth(){return this.format===this.gl.DEPTH_COMPONENT24}resize(e,t){if(e===this.width&&t===this.height)return;let r=this.gl;this.width=e,this.height=t,r.bindTexture(r.TEXTURE_2D,this.texture);let[s,i]=this.isDepth?[r.DEPTH_COMPONENT,r.UNSIGNED_INT]:this.format===r.R16F?[r.RED,r.HALF_FLOAT]:this.format===r.RGBA8?[r.RGBA,r.UNSIGNED_BYTE]:[r.RED,r.UNSIGNED_BYTE];r.texImage2D(r.TEXTURE_2D,0,this.format,e,t,0,s,i,null),r.bindFramebuffer(r.FRAMEBUFFER,this.frame),r.framebufferTexture2D(r.FRAMEBUFFER,this.isDepth?r.DEPTH_ATTACHMENT:r.COLOR_ATTACHMENT0,r.TEXTURE_2D,this.texture,0),this.isDepth&&(r.drawBuffers([r.NONE]),r.readBuffer(r.NONE))}bind(){this.gl.bindFramebuffer(this.gl.FRAMEBUFFER,this.frame),this.gl.viewport(0,0,this.width,this.height)}copyToScreen(){let e=this.gl,{width:t,height:r}=this;e.bindFramebuffer(e.READ_FRAMEBUFFER,this.frame),e.bindFramebuffer(e.DRAW_FRAMEBUFFER,null),e.blitFramebuffer(0,0,t,r,0,0,t,r,e.COLOR_BUFFER_BIT,e.NEAREST),e.bindFramebuffer(e.FRAMEBUFFER,null),e.viewport(0,0,t,r)}};var F=`#version 300 es
precision highp float;
precision highp int;
precision highp sampler2DArray;
`,te=`
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
`,pe=`
// Of each view what see() wants, and its centre in this camera.
layout(std140) uniform Views { vec4 views[1020]; };
vec4 seeView(int v, vec3 ray, float inverse, out float feather) {
  int at = 6 * v;
  return see(views[at], views[at + 1], views[at + 2], views[at + 3], views[at + 4], ray, inverse, feather);
}
`,re=`
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
`,ve=`${F}
uniform vec4 corners[3];  // of clip space
void main() { gl_Position = corners[gl_VertexID]; }`,ge=a=>`${F}${te}${re}
uniform vec4 own[${6*a}];  // of each view what see() wants, and the numerator of its weight
uniform vec3 denominator;
out vec4 color;

void main() {
  vec3 ray = rayOfPixel();
  float inverse = inverseDepth(ray);
  vec4 all = vec4(0.0);
  float feather;
${Array.from({length:a},(e,t)=>{let r=s=>`own[${6*t+s}]`;return`  {
    vec4 light = see(${[0,1,2,3,4].map(r).join(", ")}, ray, inverse, feather);
    float weight = max(dot(${r(5)}.xyz, ray), 0.0) * light.a;
    all += vec4(light.rgb * weight, weight);
  }`}).join(`
`)}
  float share = clamp(2.0 * all.a / max(dot(denominator, ray), 1e-30), 0.0, 1.0);
  color = vec4(srgb(all.rgb / max(all.a, 1e-30)), share);
}`,z=16,be=`${F}
uniform sampler2D drawn;
out vec4 color;
void main() {
  ivec2 first = ${z} * ivec2(gl_FragCoord.xy), last = textureSize(drawn, 0) - 1;
  float least = 1.0;
  for (int y = 0; y < ${z}; ++y)
    for (int x = 0; x < ${z}; ++x) least = min(least, texelFetch(drawn, min(first + ivec2(x, y), last), 0).a);
  color = vec4(least < 0.996 ? 1.0 : 0.0);
}`,we=`${F}
uniform sampler2D openTiles;
uniform vec4 camera;  // half of the width and height
void main() {
  const ivec2 corners[6] = ivec2[6](ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(0, 1), ivec2(1, 0), ivec2(1, 1));
  int columns = textureSize(openTiles, 0).x;
  ivec2 tile = ivec2(gl_InstanceID % columns, gl_InstanceID / columns);
  vec2 corner = vec2(${z} * (tile + corners[gl_VertexID])) / camera.xy - 1.0;
  gl_Position = texelFetch(openTiles, tile, 0).r > 0.5 ? vec4(corner, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
}`,ye=`${F}${te}${pe}${re}
uniform sampler2D drawn;
uniform int filling;
uniform vec3 ground;  // where there is no light
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
  color = vec4(mix(ground, color.rgb, there), 1.0);
}`,L=`${F}
uniform float depth;
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, depth, 1.0); }`,xe=`${F}${te}${pe}${re}
uniform int count;
uniform float inverseRadius;
uniform vec3 ground;  // where there is no light
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
  color = vec4(all.a > 0.0 ? srgb(all.rgb / all.a) : ground, 1.0);
}`,Ee=`${F}
layout(location = 0) in vec3 place;
uniform vec3 low, step;
uniform vec4 row0, row1, row2;  // of the camera
uniform vec4 lens;              // to clip space: x scale, y scale, x offset, y offset
uniform float near;
void main() {
  vec4 h = vec4(low + step * place, 1.0);
  vec3 p = vec3(dot(row0, h), dot(row1, h), dot(row2, h));
  gl_Position = vec4(p.xy * lens.xy + p.z * lens.zw, p.z - 2.0 * near, p.z);
}`,Te=`${F}
void main() {}`,Ae=`${F}
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
}`,Fe=`${F}
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
}`,Re=`${F}
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
}`,Ve=`${F}
uniform highp sampler2D narrow;
out vec4 color;
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(narrow, 0) - 1;
  float most = 0.0;
  for (int n = 0; n < 9; ++n)
    most = max(most, texelFetch(narrow, clamp(here + ivec2(n % 3, n / 3) - 1, ivec2(0), last), 0).r);
  color = vec4(most);
}`,Me=`${F}
uniform highp sampler2DArray hides;
uniform vec4 area;  // of the picture in its layer: offset, 1 / size
uniform float layer;
out vec4 color;
void main() {
  color = vec4(0.0, 0.0, 0.0, 1.0 - texture(hides, vec3((gl_FragCoord.xy - area.xy) * area.zw, layer)).r);
}`;var ze=125e6,B=256,Ce=3,Z=class{constructor(e,t,r,s,i){this.gl=e;this.cameras=r;this.geometry=s;this.changed=i;this.slots=[];this.decoding=new Set;this.drawing=0;this.hasMasks=!1;this.shown=0;[this.width,this.height]=t.picture;let n=t.small;this.smallWidth=Math.max(1,Math.floor(this.width/n)),this.smallHeight=Math.max(1,Math.floor(this.height/n)),this.smallLayers=Math.ceil(t.views/n**2),this.places=new Array(t.views),this.smallIn=new Array(t.views).fill(!1),this.small=new Array(t.views),this.fine=new Array(t.views);let o=e.getParameter(e.MAX_ARRAY_TEXTURE_LAYERS),h=4*this.width*this.height,d=Math.min(t.views,o),m=Math.floor((ze-d*B**2)/h)-this.smallLayers,c=Math.max(1,Math.min(t.views,m,o-this.smallLayers));this.bytes=(this.smallLayers+c)*h+d*B**2,this.texture=Y(e,e.TEXTURE_2D_ARRAY,e.LINEAR),e.texStorage3D(e.TEXTURE_2D_ARRAY,1,e.SRGB8_ALPHA8,this.width,this.height,this.smallLayers+c),this.frame=e.createFramebuffer();for(let l=0;l<c;++l)this.slots.push({view:-1,usedAt:-1});this.hides=Y(e,e.TEXTURE_2D_ARRAY,e.LINEAR),e.texStorage3D(e.TEXTURE_2D_ARRAY,1,e.R8,B,B,d),this.hidesFrame=e.createFramebuffer(),this.hidesOf=new Array(d).fill(-1),this.nearness=new P(e,e.DEPTH_COMPONENT24,e.NEAREST),this.narrow=new P(e,e.R8,e.NEAREST),this.nearness.resize(B,B),this.narrow.resize(B,B),this.narrowProgram=new A(e,L,Re),this.widenProgram=new A(e,L,Ve),this.openProgram=new A(e,L,Me),this.radius=t.radius}place(e){return this.places[e]}get masks(){return this.hasMasks||this.geometry()!==null}nearnessFactor(e){let t=p(this.cameras[e].center),r=this.radius<.5*t?(t-this.radius)/1.25:t/2.5;return Math.max(r,1e-9)}addSmall(e,t){return this.small[e]=new Blob([t],{type:"image/webp"}),this.readSmall(e)}async readSmall(e){let t=this.small[e];t&&await this.decode(e,t,this.smallWidth,this.smallHeight,r=>{let s=Math.round(this.width/this.smallWidth),i=e%s**2,n=i%s*this.smallWidth,o=Math.floor(i/s)*this.smallHeight;this.smallIn[e]||++this.shown,this.smallIn[e]=!0;let h=this.smallPlace(e);this.upload(e,r,h.layer,n,o,this.smallWidth,this.smallHeight),this.places[e]||(this.places[e]=h)})}geometryChanged(){this.hidesOf.fill(-1);for(let e of this.slots)e.view>=0&&(this.places[e.view]=this.smallIn[e.view]?this.smallPlace(e.view):void 0),e.view=-1;this.small.forEach((e,t)=>e&&void this.readSmall(t).catch(()=>{}))}smallPlace(e){let t=Math.round(this.width/this.smallWidth),r=e%t**2;return{layer:Math.floor(e/t**2),scaleX:this.smallWidth/this.width,scaleY:this.smallHeight/this.height,offsetX:r%t*this.smallWidth/this.width,offsetY:Math.floor(r/t)*this.smallHeight/this.height,fine:!1}}addFine(e,t){this.fine[e]=new Blob([t],{type:"image/webp"})}async decode(e,t,r,s,i){let n=this.cameras[e],o=r===this.width?[n.width,n.height]:[Math.floor(n.width/4),Math.floor(n.height/4)],h={premultiplyAlpha:"none",colorSpaceConversion:"none"};(o[0]!==r||o[1]!==s)&&Object.assign(h,{resizeWidth:r,resizeHeight:s,resizeQuality:"medium"});let d=await createImageBitmap(t,h).catch(()=>createImageBitmap(t));this.gl.isContextLost()||i(d),d.close(),this.decoding.delete(e),this.changed(e)}want(e){++this.drawing;for(let t of e){let r=this.slots.find(s=>s.view===t);r&&(r.usedAt=this.drawing)}for(let t of e){if(this.decoding.size>=Ce)return;let r=this.fine[t];if(!r||this.decoding.has(t)||this.slots.some(i=>i.view===t))continue;let s=this.slots.reduce((i,n)=>n.usedAt<i.usedAt?n:i);if(s.usedAt===this.drawing)return;s.view>=0&&(this.places[s.view]=this.smallIn[s.view]?this.smallPlace(s.view):void 0),s.view=t,s.usedAt=this.drawing,this.decoding.add(t),this.decode(t,r,this.width,this.height,i=>{if(s.view!==t)return;let n=this.smallLayers+this.slots.indexOf(s);this.upload(t,i,n,0,0,this.width,this.height),this.places[t]={layer:n,scaleX:1,scaleY:1,offsetX:0,offsetY:0,fine:!0}}).catch(()=>{this.fine[t]=void 0,this.decoding.delete(t),s.view=-1})}}waits(e){return e.slice(0,this.slots.length).some(t=>this.fine[t]&&!this.places[t]?.fine)}get fineViews(){return this.slots.length}noteMasks(){this.hasMasks=!0}upload(e,t,r,s,i,n,o){let h=this.gl;h.pixelStorei(h.UNPACK_PREMULTIPLY_ALPHA_WEBGL,!1),h.pixelStorei(h.UNPACK_COLORSPACE_CONVERSION_WEBGL,h.NONE),h.bindTexture(h.TEXTURE_2D_ARRAY,this.texture),h.texSubImage3D(h.TEXTURE_2D_ARRAY,0,s,i,r,n,o,1,h.RGBA,h.UNSIGNED_BYTE,t);let d=this.geometry();d&&this.hide(e,d,r,s,i,n,o)}hide(e,t,r,s,i,n,o){let h=this.gl,d=e%this.hidesOf.length;if(this.hidesOf[d]!==e){this.hidesOf[d]=e;let m=this.cameras[e],c=.02*p(m.center);this.nearness.bind(),t.drawNearness(m.camFromWorld,m.translation,[2*m.fx,2*m.fy,2*m.cx-1,2*m.cy-1],c),this.narrow.bind(),h.activeTexture(h.TEXTURE0),h.bindTexture(h.TEXTURE_2D,this.nearness.texture),this.narrowProgram.use().integer("nearness",0).numbers("depth",0).numbers("scale",this.nearnessFactor(e)/c),h.drawArrays(h.TRIANGLES,0,3),h.bindFramebuffer(h.FRAMEBUFFER,this.hidesFrame),h.framebufferTextureLayer(h.FRAMEBUFFER,h.COLOR_ATTACHMENT0,this.hides,0,d),h.bindTexture(h.TEXTURE_2D,this.narrow.texture),this.widenProgram.use().integer("narrow",0).numbers("depth",0),h.drawArrays(h.TRIANGLES,0,3)}h.bindFramebuffer(h.FRAMEBUFFER,this.frame),h.framebufferTextureLayer(h.FRAMEBUFFER,h.COLOR_ATTACHMENT0,this.texture,0,r),h.viewport(s,i,n,o),h.colorMask(!1,!1,!1,!0),h.enable(h.BLEND),h.blendFunc(h.ZERO,h.SRC_ALPHA),h.activeTexture(h.TEXTURE0),h.bindTexture(h.TEXTURE_2D_ARRAY,this.hides),this.openProgram.use().integer("hides",0).numbers("depth",0).numbers("area",s,i,1/n,1/o).numbers("layer",d),h.drawArrays(h.TRIANGLES,0,3),h.disable(h.BLEND),h.colorMask(!0,!0,!0,!0)}};var ie=[3,4,5,6,7,8,10,G],q=class{constructor(e,t,r,s){this.header=t;this.coarse=null;this.fine=null;this.fieldPrograms=[];this.ground=[0,0,0];this.pulled=[];this.pushed=[];this.corners=new Float32Array(12);this.data=new Float32Array(4080);let i=e.getContext("webgl2",{alpha:!1,antialias:!1,depth:!1,stencil:!1,powerPreference:"high-performance"});if(!i)throw new Error("This browser has no WebGL 2, which draws the pictures.");this.gl=i,this.canDrawFloats=i.getExtension("EXT_color_buffer_float")!==null||i.getExtension("EXT_color_buffer_half_float")!==null,this.cameras=me(r,t.views),this.field=r.has("triangles")?new W(r,this.cameras):new X(t,this.cameras),this.pictures=new Z(i,t,this.cameras,()=>this.geometry,s),this.nearnessProgram=new A(i,Ee,Te),this.findOpen=new A(i,L,be),this.open=new P(i,i.R8,i.NEAREST),this.fill=new A(i,we,ye),this.drawn=new P(i,i.RGBA8,i.NEAREST),this.nothing=i.createVertexArray(),this.pull=new A(i,L,Ae),this.push=new A(i,L,Fe),this.depth=new P(i,i.DEPTH_COMPONENT24,i.NEAREST),this.views=i.createBuffer(),i.bindBuffer(i.UNIFORM_BUFFER,this.views),i.bufferData(i.UNIFORM_BUFFER,this.data.byteLength,i.DYNAMIC_DRAW)}addGeometry(e,t){if(!e.geometry)return;let r=new $(this.gl,this.nearnessProgram,e.geometry,t);e.coarse?this.coarse=r:this.fine=r,this.pictures.geometryChanged()}get geometry(){return this.fine??this.coarse}pointAt(e,t,r){let s=[(t-.5*e.width)/e.focalPx,(r-.5*e.height)/e.focalPx,1],i=U(e.camFromWorld,s),n=g(M(e.eye),-1),o=p(e.eye)/Math.max(x(i,n),.001);return T(e.eye,g(i,this.geometry?.hit(e.eye,i)??o))}put(e,t,r){let s=this.pictures.place(t),i=this.cameras[t],n=24*e,o=i.camFromWorld,h=r.camFromWorld,d=T(V(o,r.eye),i.translation);for(let l=0;l<3;++l){for(let u=0;u<3;++u)this.data[n+4*l+u]=o[3*l]*h[3*u]+o[3*l+1]*h[3*u+1]+o[3*l+2]*h[3*u+2];this.data[n+4*l+3]=d[l]}for(let l=0;l<4;++l){let u=this.data[n+8+l];this.data[n+l]=i.fx*this.data[n+l]+i.cx*u,this.data[n+4+l]=i.fy*this.data[n+4+l]+i.cy*u}let m=this.header.feather*Math.min(i.width,i.height),c=V(h,y(i.center,r.eye));this.data.set([i.width/m,i.height/m,s.layer,this.pictures.nearnessFactor(t)],n+12),this.data.set([s.scaleX,s.scaleY,s.offsetX,s.offsetY],n+16),this.data.set([...c,0],n+20)}uploadViews(e){let t=this.gl;t.bindBuffer(t.UNIFORM_BUFFER,this.views),t.bufferData(t.UNIFORM_BUFFER,this.data.byteLength,t.DYNAMIC_DRAW),t.bufferSubData(t.UNIFORM_BUFFER,0,this.data,0,24*e),t.bindBufferBase(t.UNIFORM_BUFFER,0,this.views)}near(e){return .02*p(e.eye)}drawDepth(e,t){let r=this.gl;this.depth.bind();let s=t?this.coarse??this.fine:this.geometry;if(!s)return r.clear(r.DEPTH_BUFFER_BIT),!1;if(s.drawNearness(e.camFromWorld,g(V(e.camFromWorld,e.eye),-1),[2*e.focalPx/e.width,-2*e.focalPx/e.height,0,0],this.near(e)),!this.canDrawFloats)return!1;let i=[];for(let n=e.width+1>>1,o=e.height+1>>1;n>1||o>1;)i.push([n=n+1>>1,o=o+1>>1]);for(;this.pulled.length<i.length;)this.pulled.push(new P(r,r.R16F,r.NEAREST)),this.pushed.push(new P(r,r.R16F,r.LINEAR));r.activeTexture(r.TEXTURE0),this.pull.use().integer("finer",0).numbers("depth",0),i.forEach(([n,o],h)=>{let d=this.pulled[h];d.resize(n,o),this.pull.integer("ofNearness",h===0?1:0),d.bind(),r.bindTexture(r.TEXTURE_2D,h===0?this.depth.texture:this.pulled[h-1].texture),r.drawArrays(r.TRIANGLES,0,3)}),this.push.use().integer("coarser",0).integer("pulled",1).numbers("depth",0);for(let n=i.length-2;n>=0;--n){let o=this.pushed[n];o.resize(...i[n]),o.bind(),r.activeTexture(r.TEXTURE0),r.bindTexture(r.TEXTURE_2D,n===i.length-2?this.pulled[n+1].texture:this.pushed[n+1].texture),r.activeTexture(r.TEXTURE1),r.bindTexture(r.TEXTURE_2D,this.pulled[n].texture),r.drawArrays(r.TRIANGLES,0,3)}return i.length>1}setPixels(e,t,r,s){let i=this.gl,n=this.near(t),o=p(t.eye),h=g(V(t.camFromWorld,t.eye),-1/o**2);e.use().integer("pictures",0).integer("nearness",1).integer("holes",2).numbers("masks",this.pictures.masks&&r===0?1:0).numbers("camera",.5*t.width,.5*t.height,1/t.focalPx,1/n).numbers("plane",...h,.001/o).numbers("focusInverse",r).numbers("holesScale",s?1/n:0),i.activeTexture(i.TEXTURE0),i.bindTexture(i.TEXTURE_2D_ARRAY,this.pictures.texture),i.activeTexture(i.TEXTURE1),i.bindTexture(i.TEXTURE_2D,this.depth.texture),i.activeTexture(i.TEXTURE2),i.bindTexture(i.TEXTURE_2D,s?this.pushed[0].texture:this.depth.texture)}draw(e,t,r){let s=this.gl;s.disable(s.BLEND),this.depth.resize(e.width,e.height);let i=t?!1:this.drawDepth(e,r),n=t?this.focusDepth(e,t):0,o=t?this.viewsThrough(e,t):[];return o.length>0&&t?this.drawAperture(e,t,o,n):this.drawField(e,t?1/n:0,i,r)}focusDepth(e,t){let r=V(e.camFromWorld,y(t.focus,e.eye));return Math.max(r[2],.001*p(r),1e-9)}viewsThrough(e,t){let r=this.cameras.map((i,n)=>{let o=V(e.camFromWorld,y(i.center,e.eye));return[Math.hypot(o[0],o[1]),n]}).filter(([i,n])=>i<1.2*t.radius&&this.pictures.place(n)).sort((i,n)=>i[0]-n[0]).map(([,i])=>i);return r.length>=4?r.slice(0,170):[]}drawAperture(e,t,r,s){r.forEach((o,h)=>this.put(h,o,e)),this.uploadViews(r.length);let i=this.gl,n=this.apertureProgram??=new A(i,L,xe);return this.setPixels(n,e,1/s,!1),i.bindFramebuffer(i.FRAMEBUFFER,null),i.viewport(0,0,e.width,e.height),n.integer("count",r.length).numbers("inverseRadius",1/t.radius).numbers("depth",0).numbers("ground",...this.ground),i.drawArrays(i.TRIANGLES,0,3),r}nearestViews(e,t){return this.byAngle(e).filter(r=>this.pictures.place(r)).slice(0,t)}byAngle(e){return this.cameras.map((t,r)=>[D(t.center,e.eye),r]).sort((t,r)=>t[0]-r[0]).map(([,t])=>t)}drawField(e,t,r,s){let i=this.gl,n=this.nearestViews(e,16),o=new Map;this.drawn.resize(e.width,e.height),this.drawn.bind(),i.clearColor(0,0,0,0),i.clear(i.COLOR_BUFFER_BIT),i.bindVertexArray(this.nothing);let h=this.field.place(e,s),d=h.map(l=>l.fans.filter(u=>this.pictures.place(u.view))),m=-1;return h.forEach((l,u)=>{for(let w of l.fans)o.set(w.view,(o.get(w.view)??0)+Math.max(0,w.numerator[2])/Math.max(l.denominator[2],1e-9));let f=d[u];if(f.length===0)return;let v=ie.findIndex(w=>w>=f.length),b=this.fieldPrograms[v]??=new A(i,ve,ge(ie[v]));v!==m&&this.setPixels(b,e,t,r),m=v;let _=ie[v];for(let w=0;w<_;++w){let C=f[Math.min(w,f.length-1)];this.put(w,C.view,e),this.data.set(w<f.length?C.numerator:[0,0,0],4*(6*w+5))}l.corners.forEach((w,C)=>this.corners.set([w[0],w[1],0,w[2]],4*C)),b.vectors("own",this.data.subarray(0,24*_)).vectors("corners",this.corners).numbers("denominator",...l.denominator),i.drawArrays(i.TRIANGLES,0,3)}),n.forEach((l,u)=>this.put(u,l,e)),this.uploadViews(n.length),this.open.resize(Math.ceil(e.width/z),Math.ceil(e.height/z)),this.open.bind(),i.activeTexture(i.TEXTURE3),i.bindTexture(i.TEXTURE_2D,this.drawn.texture),this.findOpen.use().integer("drawn",3).numbers("depth",0),i.drawArrays(i.TRIANGLES,0,3),this.drawn.copyToScreen(),this.setPixels(this.fill,e,t,r),i.activeTexture(i.TEXTURE3),i.bindTexture(i.TEXTURE_2D,this.drawn.texture),i.activeTexture(i.TEXTURE4),i.bindTexture(i.TEXTURE_2D,this.open.texture),this.fill.integer("drawn",3).integer("openTiles",4).integer("filling",n.length).numbers("ground",...this.ground),i.drawArraysInstanced(i.TRIANGLES,0,6,this.open.width*this.open.height),i.bindVertexArray(null),[...[...o].sort((l,u)=>u[1]-l[1]).map(([l])=>l),...n.filter(l=>!o.has(l)).slice(0,4)]}finish(){this.gl.readPixels(0,0,1,1,this.gl.RGBA,this.gl.UNSIGNED_BYTE,new Uint8Array(4))}};function R(a){return document.getElementById(a)}async function Ne(){let a=document.getElementById("poster");if(!a)return;let e=(h="")=>h.split(" ").map(Number),[t=1,r=1,s=1]=e(a.dataset.lens),[i=0,n=1]=e(a.dataset.subject),o=Q({width:t,height:r,focal:s},i,n,innerWidth||1,innerHeight||1);a.style.transform=`scale(${o})`,a.style.opacity="1",await a.decode().catch(()=>{}),await new Promise(h=>requestAnimationFrame(()=>setTimeout(h)))}var _e=a=>new Promise(e=>setTimeout(e,a)),se=class{constructor(){this.canvas=R("picture");this.progress=R("progress");this.status=R("status");this.apertureSlider=R("aperture");this.focusSlider=R("focus");this.lens=R("lens");this.help=R("help");this.renderer=null;this.header=null;this.orbit=null;this.waiting=[];this.pace=new H;this.focus=[0,0,0];this.shown=[];this.asked=!1;this.movedAt=-1/0;this.hasMoved=!1;this.moves=!1;this.lastFrameAt=0;this.later=0;this.begun=()=>{};this.hasBegun=new Promise(e=>this.begun=e);this.loadedBytes=0;this.hasTurned=!1;this.figures={frames:0,firstPictureMs:0,complete:!1,scale:1,failed:""};let t=Promise.race([Ne(),_e(400)]);oe((r,s)=>{r.kind==="scene"?t.then(()=>this.receive(r,s)):this.receive(r,s)}),this.connect()}receive(e,t){try{if(e.kind==="scene")this.begin(e,t);else if(!this.renderer)this.waiting.push([e,t]);else if(e.kind==="geometry")this.renderer.addGeometry(e,new I(e.arrays,t));else for(let[r,s,i]of e.views){let n=t.slice(s,s+i);e.kind==="fine"?this.renderer.pictures.addFine(r,n):this.renderer.pictures.addSmall(r,n).catch(o=>this.fail(o))}e.kind==="fine"?this.fetch():e.kind==="geometry"&&this.draw()}catch(r){this.fail(r)}}begin(e,t){this.header=e,this.renderer=new q(this.canvas,e,new I(e.arrays,t),n=>this.arrived(n)),e.masks&&this.renderer.pictures.noteMasks();let r=()=>{let n=getComputedStyle(document.body).backgroundColor.match(/[\d.]+/g)??[],[o=0,h=0,d=0]=n.map(m=>Number(m)/255);this.renderer&&(this.renderer.ground=[o,h,d]),this.draw()};matchMedia("(prefers-color-scheme: dark)").addEventListener("change",r),this.orbit=new k(e,this.renderer.field);let{width:s,height:i}=this.size(1);this.orbit.reset(s,i),r();for(let[n,o]of this.waiting.splice(0))this.receive(n,o);new ResizeObserver(()=>{let n=this.size(1);this.orbit?.setZoom(this.orbit.zoom,n.width,n.height),this.draw()}).observe(this.canvas),this.canvas.addEventListener("webglcontextlost",()=>this.say("The device took the graphics away. Reload the page.")),addEventListener("load",()=>{this.loadRest(e)}),document.readyState==="complete"&&this.loadRest(e)}async loadRest(e){await Promise.race([this.hasBegun,_e(3e3)]);let r=e.files.reduce((n,[,o])=>n+o,0),s=[...e.files],i=async()=>{for(let n=s.shift();n;n=s.shift()){await ae(n[0]),this.loadedBytes+=n[1];let o=r>0?this.loadedBytes/r:1;this.progress.style.setProperty("--share",o.toFixed(3)),this.progress.setAttribute("aria-valuenow",String(Math.round(100*o)))}};try{await Promise.all([i(),i()]),this.progress.classList.add("done"),this.progress.setAttribute("aria-hidden","true"),this.status.textContent="All pictures are loaded."}catch(n){this.progress.classList.add("done"),this.say("Some pictures could not be loaded. Reload the page to try again."),console.warn(n)}this.draw()}say(e){let t=R("message");t.textContent=e,t.hidden=!1}fail(e){this.figures.failed=String(e),this.say(e instanceof Error&&e.message.startsWith("This browser")?e.message:"The light field cannot be shown here."),console.error(e)}size(e){let r=this.canvas.clientWidth||1,s=this.canvas.clientHeight||1,i=Math.min(devicePixelRatio||1,2,Math.sqrt(26e5/(r*s)));return{width:Math.max(1,Math.round(r*i*e)),height:Math.max(1,Math.round(s*i*e))}}get aperture(){let e=Number(this.apertureSlider.value);if(!this.header||!this.orbit||e<=0)return null;let t=p(this.orbit.eye),r=(this.header.spacing||.1)*t;return{radius:r*1.3*(.35*t/(1.3*r))**((e-1)/99),focus:this.focus}}draw(){this.asked||!this.renderer||(this.asked=!0,requestAnimationFrame(e=>this.frame(e)))}frame(e){if(this.asked=!1,!this.renderer||!this.orbit||this.renderer.pictures.shown===0)return;let r=this.hasMoved||e-this.movedAt<180;this.hasMoved=!1;let s=this.figures.frames===0,i=s?J:r?this.pace.size:1,{width:n,height:o}=this.size(i);(this.canvas.width!==n||this.canvas.height!==o)&&(this.canvas.width=n,this.canvas.height=o);let h=s||r&&this.pace.simple;this.shown=this.renderer.draw(this.orbit.camera(n,o),this.aperture,h),this.fetch(),s&&(this.renderer.finish(),this.figures.firstPictureMs=performance.now(),document.body.classList.add("shows"),setTimeout(()=>document.getElementById("poster")?.remove(),500),this.begun(),this.draw()),++this.figures.frames,this.figures.scale=i,this.figures.complete=this.progress.classList.contains("done")&&!this.renderer.pictures.waits(this.shown),r&&(this.moves&&this.pace.note(e-this.lastFrameAt),this.draw()),this.moves=r,this.lastFrameAt=e}fetch(){if(!this.renderer||!this.orbit)return;let{pictures:e}=this.renderer,t=Math.floor(.8*e.fineViews),r=this.renderer.byAngle(this.orbit.camera(1,1)).slice(0,t);e.want([...this.shown,...r.filter(s=>!this.shown.includes(s))])}arrived(e){if(this.figures.frames>0&&!this.shown.includes(e))return this.fetch();let t=this.figures.frames===0?0:250,r=this.lastFrameAt+t-performance.now();r<=0?this.draw():this.later||(this.later=setTimeout(()=>{this.later=0,this.draw()},r)),this.fetch()}moved(){this.movedAt=performance.now(),this.hasMoved=!0,this.draw()}turn(e,t){this.orbit?.turn(e,t)&&this.moved(),this.hasTurned||(this.hasTurned=!0,document.body.classList.add("used"))}zoomBy(e){if(!this.orbit)return;let{width:t,height:r}=this.size(1);this.orbit.setZoom(this.orbit.zoom*e,t,r),this.showZoom(),this.moved()}showZoom(){if(!this.orbit)return;let{width:e,height:t}=this.size(1);R("zoom_in").disabled=this.orbit.zoom>=j-1e-6,R("zoom_out").disabled=this.orbit.zoom<=this.orbit.leastZoom(e,t)+1e-6}reset(){if(!this.orbit)return;let{width:e,height:t}=this.size(1);this.orbit.reset(e,t),this.apertureSlider.value="0",this.setFocus([0,0,0]),this.showZoom(),this.moved()}setFocus(e){if(this.focus=e,!this.orbit||!this.header)return;let t=this.orbit.camera(1,1),r=V(t.camFromWorld,y(e,t.eye))[2];this.focusSlider.value=String(100*(r/p(t.eye)-.6)/.9),this.draw()}focusAt(e,t){if(!this.orbit||!this.renderer||!this.aperture)return;let r=this.canvas.getBoundingClientRect(),s=this.orbit.camera(Math.round(r.width),Math.round(r.height));this.setFocus(this.renderer.pointAt(s,e-r.left,t-r.top));let i=R("mark");i.style.left=`${e-r.left}px`,i.style.top=`${t-r.top}px`,i.classList.remove("seen"),i.offsetWidth,i.classList.add("seen")}focusFromSlider(){if(!this.orbit)return;let e=this.orbit.camera(1,1),t=p(e.eye)*(.6+.9*Number(this.focusSlider.value)/100);this.focus=T(e.eye,U(e.camFromWorld,g([0,0,1],t))),this.moved()}step(e,t){e.value=String(S(Number(e.value)+t,0,100)),e.dispatchEvent(new Event("input"))}toggleLens(e=this.lens.hidden){this.lens.hidden=!e,R("depth_of_field").setAttribute("aria-expanded",String(e)),document.body.classList.add("used"),e&&Number(this.apertureSlider.value)===0&&this.step(this.apertureSlider,35),e&&this.apertureSlider.focus()}async toggleFullscreen(){document.fullscreenElement?await document.exitFullscreen():await document.documentElement.requestFullscreen()}key(e){if(this.help.open)return!1;let t=e.shiftKey?.01:.05,r={ArrowLeft:()=>this.turn(-t,0),ArrowRight:()=>this.turn(t,0),ArrowUp:()=>this.turn(0,t),ArrowDown:()=>this.turn(0,-t),"+":()=>this.zoomBy(1.1),"=":()=>this.zoomBy(1.1),"-":()=>this.zoomBy(1/1.1),Home:()=>this.reset(),0:()=>this.reset(),o:()=>this.step(this.apertureSlider,5),i:()=>this.step(this.apertureSlider,-5),u:()=>this.step(this.focusSlider,3),j:()=>this.step(this.focusSlider,-3),f:()=>{this.toggleFullscreen().catch(()=>{})},"?":()=>this.help.showModal(),Escape:()=>this.toggleLens(!1)},s=r[e.key]??r[e.key.toLowerCase()];return e.key==="Escape"&&this.lens.hidden?!1:(s?.(),s!==void 0)}connect(){de(this.canvas,{turn:(r,s)=>this.turn(r,s),zoomBy:r=>this.zoomBy(r),focusAt:(r,s)=>this.focusAt(r,s),key:r=>this.key(r),rest:()=>this.draw()});let e=(r,s)=>R(r).addEventListener("click",s);e("zoom_in",()=>this.zoomBy(1.25)),e("zoom_out",()=>this.zoomBy(1/1.25)),e("again",()=>this.reset()),e("depth_of_field",()=>this.toggleLens()),e("show_help",()=>this.help.showModal()),e("close_help",()=>this.help.close()),this.help.addEventListener("click",r=>{r.target===this.help&&this.help.close()});let t=R("fullscreen");document.fullscreenEnabled?(t.addEventListener("click",()=>{this.toggleFullscreen().catch(()=>{})}),document.addEventListener("fullscreenchange",()=>t.setAttribute("aria-pressed",String(document.fullscreenElement!==null)))):t.hidden=!0,this.apertureSlider.addEventListener("input",()=>this.moved()),this.focusSlider.addEventListener("input",()=>this.focusFromSlider())}lookFrom(e,t){this.orbit&&(this.orbit.eye=e,this.orbit.zoom=t,this.draw())}openLens(e){this.apertureSlider.value=String(e),this.draw()}};window.ulfPage=new se;})();
